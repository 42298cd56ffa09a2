"""The axis that rings: margins of a tune by throttle and schedule of b0, and the change that helps most.

The acceleration gain of the rotors grows with the collective t as (t/h)^growth. Two craft of 5 in measured 1.3 to 1.7 from hover
to 40 to 60 %, and 0.56 at 10 to 15 %: a growth of about 0.5, where the schedule SQRT leaves the margin as it is at hover.
"""

from collections.abc import Iterator, Mapping, Sequence
from math import inf, isfinite

import numpy as np

from tuner.extensions.betaflight_adrc.document import ChangeRow, RingRow
from tuner.extensions.betaflight_adrc.equations import limited_scale, schedule_scale
from tuner.extensions.betaflight_adrc.linear_loop import (
    AxisPlant,
    Sampling,
    controller_response,
    filter_response,
    loop_response,
    margins,
    scaled,
)
from tuner.extensions.betaflight_adrc.settings import LAG, SCHEDULES, SETTINGS, Tune

REFERENCE = {
    "roll": (6560.0, AxisPlant.identified(135.2, 0.0211, 0.0022, 250e-6)),
    "pitch": (3936.0, AxisPlant.identified(92.9, 0.0214, 0.0023, 250e-6)),
    "yaw": (2624.0, AxisPlant.identified(13.2, 0.0256, 0.0026, 250e-6, 0.130)),
}
"""Axis -> b0 and plant of the 2.5 in craft TH3+, by chirp; published with its flights (danusha2345/ADRC-betaflight)."""
IDLE, HIGH_THROTTLES = 0.15, (0.5, 0.8)
DEFAULT_GROWTH = 0.5
SLOW_FREQUENCY = 2.0
"""Frequency of disturbances that the loop is to reject [Hz]."""
SHARES = {"wo": 0.8, "wc": 0.8, "b0": 1.25}
"""Proposed value over the present one, by setting."""
CUTOFF_FACTOR = 1.5


def plants_of_b0(tune: Tune) -> dict[str, AxisPlant]:
    """Return the plants of the reference craft, scaled by the tune's b0."""
    return {axis: scaled(plant, tune.of("b0", axis) / b0) for axis, (b0, plant) in REFERENCE.items()}


def throttles(tune: Tune, pack: float = 1.0) -> tuple[float, ...]:
    """Return the collectives of a forecast, from idle on; one hovers with a pack."""
    return tuple(sorted({IDLE, min(_hover(tune) / pack, 1.0), *HIGH_THROTTLES}))


def _hover(tune: Tune) -> float:
    return 0.01 * tune.numbers["adrc_hover_throttle"]


def scale_at(tune: Tune, schedule: str, throttle: float, is_open: bool = True) -> float:
    """Return the scale of b0 at a steady collective."""
    constants = tune.gate(1e-3)
    raw = schedule_scale(SCHEDULES[schedule], throttle / constants.hover)
    return limited_scale(raw, 1.0 if is_open else 0.0, constants)


def authority_at(tune: Tune, throttle: float, growth: float, pack: float = 1.0) -> float:
    """Return the acceleration gain of the rotors over that at hover.

    A rotor turns at a speed in proportion to voltage and command, so both count in the growth, and the voltage once more.
    """
    return pack * (pack * throttle / _hover(tune)) ** growth


def largest_gain(tune: Tune, growth: float, packs: Sequence[float]) -> float:
    """Return the largest loop gain in flight over that at hover."""
    conditions = [(pack, throttle) for pack in packs for throttle in throttles(tune, pack)]
    return max(
        authority_at(tune, throttle, growth, pack) / scale_at(tune, tune.schedule, throttle)
        for pack, throttle in conditions
    )


def rings(
    tune: Tune,
    plants: Mapping[str, AxisPlant],
    sampling: Sampling,
    growth: float = DEFAULT_GROWTH,
    schedules: Sequence[str] = tuple(SCHEDULES),
    packs: Sequence[float] = (1.0,),
) -> Iterator[RingRow]:
    """Yield the margins of each axis in flight and on the ground.

    Args:
        tune: Settings.
        plants: Plant of each axis at hover.
        sampling: Rates and filters.
        growth: Exponent of the acceleration gain over the collective.
        schedules: Names of the schedules of b0.
        packs: Voltages of the packs, over that of the plants.
    """
    conditions = [
        condition
        for pack in packs
        for condition in (
            *((pack, schedule, throttle, "open") for schedule in schedules for throttle in throttles(tune, pack)),
            (pack, tune.schedule, IDLE, "shut"),
        )
    ]
    for axis in plants:
        for pack, schedule, throttle, gate in conditions:
            is_open = gate == "open"
            # On the ground airmode raises the applied collective to that of hover and beyond.
            plant = scaled(plants[axis], authority_at(tune, throttle, growth, pack) if is_open else pack)
            margin = margins(tune, axis, plant, sampling, scale_at(tune, schedule, throttle, is_open), is_open)
            gain, ring, phase = (value if isfinite(value) else None for value in margin[:3])
            yield RingRow(
                axis=axis,
                schedule=schedule,
                throttle=throttle,
                gate=gate,
                pack=pack,
                gain_margin=gain,
                ring=ring,
                phase_margin=phase,
            )


def worst_ring(conditions: Sequence[RingRow], schedule: str, gate: str = "open") -> RingRow:
    """Return the condition with the smallest gain margin."""
    selected = [row for row in conditions if (row.schedule, row.gate) == (schedule, gate)]
    # Where a schedule follows the rotors, margins of several throttles differ by rounding: the lowest throttle counts.
    return min(selected, key=lambda row: round(row.gain_margin or inf, 6))


def changes(tune: Tune, plant: AxisPlant, sampling: Sampling, ring: RingRow, growth: float) -> list[ChangeRow]:
    """Return the changes that raise a gain margin, the best one first.

    Args:
        tune: Settings.
        plant: Plant of the axis at hover.
        sampling: Rates and filters.
        ring: Condition to improve, in flight.
        growth: Exponent of the acceleration gain over the collective.
    """
    plant, axis = scaled(plant, authority_at(tune, ring.throttle, growth, ring.pack)), ring.axis
    scale = scale_at(tune, ring.schedule, ring.throttle)
    stiff, loud = stiffness(tune, axis, plant, sampling, scale), noise(tune, axis, sampling, scale)
    rows = []
    for settings in _proposals(tune, axis, plant):
        changed = tune.with_numbers(settings)
        margin = margins(changed, axis, plant, sampling, scale)
        if margin.gain > (ring.gain_margin or inf):
            rows.append(
                ChangeRow(
                    settings=settings,
                    gain_margin=margin.gain,
                    ring=margin.ring,
                    stiffness=stiffness(changed, axis, plant, sampling, scale) / stiff,
                    noise=noise(changed, axis, sampling, scale) / loud,
                )
            )
    return sorted(rows, key=lambda row: -row.gain_margin)


def _proposals(tune: Tune, axis: str, plant: AxisPlant) -> Iterator[dict[str, float]]:
    """Yield settings to try, within their ranges."""
    values = {f"adrc_{name}_{axis}": share * tune.of(name, axis) for name, share in SHARES.items()}
    if cutoff := tune.numbers["adrc_gyro_lpf_hz"]:
        values["adrc_gyro_lpf_hz"] = CUTOFF_FACTOR * cutoff
    if axis != "yaw" and tune.build.has(LAG):
        values[LAG] = 1e3 * plant.lag
    for name, value in values.items():
        yield {name: SETTINGS[name].nearest(value)}


def stiffness(tune: Tune, axis: str, plant: AxisPlant, sampling: Sampling, scale: float) -> float:
    """Return the loop gain at a slow disturbance."""
    return float(np.abs(loop_response(tune, axis, plant, sampling, np.array([SLOW_FREQUENCY]), scale)[0]))


def noise(tune: Tune, axis: str, sampling: Sampling, scale: float) -> float:
    """Return the output from white noise of the gyro [1 per deg/s]."""
    constants = tune.axis(axis, sampling.period)
    frequency = np.linspace(0.0, 0.5 / sampling.period, 2001)[1:-1]
    z = np.exp(2j * np.pi * frequency * sampling.period)
    response = controller_response(constants, scale, True, z, sampling.period)
    return float(np.sqrt(np.mean(np.abs(response * filter_response(constants, sampling, frequency)) ** 2)))
