"""The law against Betaflight's own rate controller, sample by sample: what differs is the rounding of its float32."""

from collections.abc import Iterator, Sequence
from math import radians

import numpy as np
import pytest
from numpy.typing import NDArray

from plant.contract.axis import defaults
from plant.law_registry import LAWS
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from tests.clients.betaflight_pid import NEITHER, RateController

Array = NDArray[np.float64]
LAW = LAWS["betaflight"]
AXES = ("roll", "pitch", "yaw")
# Numbers of the firmware's choices.
PD, D = 0, 1
RP, RPY = 1, 2
# Largest difference over the largest sum of a run: float32 has 7 digits; the firmware's notch, in float32 with a sine and a cosine
# that are approximations, loses one or two of them.
ROUNDING, WITH_NOTCH = 4e-6, 1e-4


@pytest.fixture(scope="module")
def firmware(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RateController]:
    yield RateController(tmp_path_factory.mktemp("betaflight"))


def drawn(seed: int) -> tuple[list[int], list[int], int]:
    """Return gains, filters and a period of a random profile, every filter on in most of them."""
    rng = np.random.default_rng(seed)
    gains = [int(high) for high in rng.integers([20, 0, 0] * 3 + [20], [120, 150, 60] * 3 + [120])]
    centre = int(rng.integers(90, 250))
    notch = [centre, int(centre * rng.uniform(0.6, 0.9))] if seed % 4 else [0, 0]
    filters = [
        *rng.integers(80, 400, 2).tolist(),
        *notch,
        *rng.integers(50, 250, 2).tolist(),
        int(rng.integers(40, 200)),
    ]
    return gains, filters, int(rng.choice([125, 250, 500, 1000]))


def motion(seed: int, count: int, scale: float) -> Array:
    """Return smooth random signals (count, 3)."""
    rng = np.random.default_rng(seed)
    return scale * np.cumsum(rng.standard_normal((count, 3)), axis=0) / np.sqrt(count) + rng.standard_normal((count, 3))


def flown(
    gains: list[int],
    filters: list[int],
    period: int,
    setpoint: Array,
    rate: Array,
    angle: Array | None,
    large: Sequence[int] = NEITHER,
) -> Array:
    """Return the outputs of our law for the same signals, in units of the firmware's sum; large: as the client takes it."""
    throttle, tpa_rate, tpa_breakpoint, tpa_mode, relax, relax_cutoff = map(float, large)
    # The firmware's threshold is 40 deg/s, a fifth of it in angle mode.
    threshold = 40.0 if angle is None else 8.0
    attenuated = {"tpa_rate": tpa_rate, "tpa_breakpoint": tpa_breakpoint, "tpa_p": 1.0 - tpa_mode}
    sums = np.empty_like(rate)
    h = 1e-6 * period
    for k, axis in enumerate(AXES):
        usual = {gain.name: LAW.span(gain, axis, "attitude").default for gain in LAW.gains}
        p, i, d = gains[3 * k : 3 * k + 3]
        names = ("gyro_lpf1", "gyro_lpf2", "notch", "notch_cutoff", "d_lpf1", "d_lpf2")
        own = dict(zip(names, map(float, filters), strict=False))
        chosen = {**usual, **own, "p": p, "i": i, "d": d, "angle_p": gains[9], "authority": 1.0, "limit": 1e9}
        chosen["p_cutoff"] = float(filters[6]) if axis == "yaw" else 0.0
        level = angle is not None and axis != "yaw"
        chosen["angle_p"] = gains[9] if level else 0.0
        chosen |= {**attenuated, "throttle": 0.01 * throttle, "relax_cutoff": relax_cutoff}
        chosen["relax"] = threshold if relax == RPY or (relax == RP and axis != "yaw") else 0.0
        constants = LAW.prepare(LAW.Gains(**chosen), h)
        # The firmware's filters begin at 0.
        memory = LAW.start(constants, Measured(0.0, 0.0), 0.0)
        for n in range(len(rate)):
            place = radians(0.1 * angle[n, k]) if level and angle is not None else 0.0
            wanted = (
                Setpoint(radians(setpoint[n, k]), 0.0, 0.0) if level else Setpoint(0.0, radians(setpoint[n, k]), 0.0)
            )
            seen = Measured(place, radians(rate[n, k]))
            sums[n, k], memory = LAW.step(memory, constants, Channel(1.0, 0.0), wanted, seen, Applied(0.0, 0.0), h)
    return sums


def check_same(ours: Array, theirs: Array, filters: list[int]) -> None:
    """Our outputs are the firmware's, to the rounding of its arithmetic."""
    apart = np.abs(ours - theirs).max(axis=(0, 1)) / np.abs(theirs).max(axis=(0, 1))
    assert apart < (WITH_NOTCH if filters[2] else ROUNDING), apart


@pytest.mark.parametrize("seed", range(20))
def test_rates_are_controlled_as_betaflight_does(firmware: RateController, seed: int) -> None:
    gains, filters, period = drawn(seed)
    setpoint, rate = motion(seed, 400, 200.0), motion(seed + 100, 400, 200.0)
    theirs = firmware.run(gains, filters, period, setpoint, rate)
    ours = flown(gains, filters, period, setpoint, rate, None)
    assert np.abs(theirs).max(axis=0).min(axis=0) > 10.0
    check_same(ours, theirs, filters)


@pytest.mark.parametrize("seed", range(4))
def test_angles_are_controlled_as_betaflight_does(firmware: RateController, seed: int) -> None:
    gains, filters, period = drawn(seed)
    setpoint, rate = np.clip(motion(seed, 400, 20.0), -40.0, 40.0), motion(seed + 100, 400, 50.0)
    angle = np.rint(10.0 * np.clip(motion(seed + 200, 400, 20.0), -40.0, 40.0))
    theirs = firmware.run(gains, filters, period, setpoint, rate, angle)
    check_same(flown(gains, filters, period, setpoint, rate, angle), theirs, filters)


@pytest.mark.parametrize("seed", range(8))
def test_throttle_attenuates_and_moving_set_points_relax_as_in_betaflight(firmware: RateController, seed: int) -> None:
    """In both modes of TPA, below and above its breakpoint, with I-term relax of two axes and of three, in rate and angle mode."""
    gains, filters, period = drawn(seed)
    large = (
        (70, 65, 1350, D, RP, 15),
        (20, 80, 1350, PD, RPY, 7),
        (95, 100, 1200, PD, RP, 30),
        (100, 65, 1350, D, RPY, 15),
    )[seed % 4]
    setpoint, rate = motion(seed, 400, 60.0), motion(seed + 100, 400, 60.0)
    angle = np.rint(10.0 * np.clip(motion(seed + 200, 400, 20.0), -40.0, 40.0)) if seed > 3 else None
    setpoint = setpoint if angle is None else np.clip(setpoint, -40.0, 40.0)
    theirs = firmware.run(gains, filters, period, setpoint, rate, angle, large)
    check_same(flown(gains, filters, period, setpoint, rate, angle, large), theirs, filters)
    # Both have a say.
    without = flown(gains, filters, period, setpoint, rate, angle)
    assert np.abs(theirs - without)[:, 0].max(axis=0) > 0.01 * np.abs(theirs)[:, 0].max(axis=0)


def test_the_integral_is_limited_as_betaflights(firmware: RateController) -> None:
    gains, filters = [45, 200, 0] * 3 + [50], [0, 0, 0, 0, 0, 0, 0]
    setpoint, rate = np.full((2000, 3), 300.0), np.zeros((2000, 3))
    theirs = firmware.run(gains, filters, 1000, setpoint, rate)
    ours = flown(gains, filters, 1000, setpoint, rate, None)
    assert theirs[-1, 0] == pytest.approx(0.032029 * 45 * 300 + 400.0, rel=1e-5)
    check_same(ours, theirs, filters)
    assert defaults(LAW, "attitude").i_limit == 400.0
