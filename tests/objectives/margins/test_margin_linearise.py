"""The linearised loop is that of the flown code: against finite differences of plain Python, and trims that stay put."""

import numpy as np
import pytest

from objectives.margins.closing import close_terms
from objectives.margins.describing import Case, term_gains
from objectives.margins.period import PeriodMap
from objectives.margins.structure import blocks_of, coordinates
from objectives.margins.trim import (
    Trim,
    balanced_plant,
    find_trim,
    mean_pole,
    setting_of,
    smooth_dynamics,
)
from plant.errors import InputError
from plant.law_registry import LAWS
from plant.quadrotor.airframes import load
from plant.quadrotor.features import vehicle_features
from plant.quadrotor.nominal import ControlOptions, nominal, vary
from plant.records import paths
from plant.vectors import Vec3
from tests.objectives.margins.designs import (
    HUMMINGBIRD,
    OPTIONS,
    TIMING,
    H,
    cascade_of,
    default_gains,
    model_of,
    random_gains,
)
from tests.objectives.margins.stepping import Stepper

WINDY = Trim(yaw=0.7, wind=Vec3(4.0, 2.0, 0.5))
TRIMS = {
    "hover": Trim(),
    "turned in wind": WINDY,
    "forward": Trim(velocity=Vec3(3.0, 0.0, 0.0)),
    "attitude": Trim(hold=False),
}
CASES = (Case(0.3),)


def linearised(pair, trim, options, gains, vehicle=HUMMINGBIRD, assumed=HUMMINGBIRD):
    """Stepper with straight terms, trim point and closed loops of one design, whose controller assumes a vehicle."""
    cascade, knowledge = cascade_of(*pair), nominal(assumed, options, H)
    features = vehicle_features(assumed, H)
    period = PeriodMap(cascade, TIMING, features)
    term = term_gains(period.terms, period.constants(gains), len(gains), CASES)[:, 0]
    setting = setting_of(trim, knowledge, vehicle)
    plant = balanced_plant(period, trim, knowledge, setting)
    point = find_trim(period, gains, setting, plant, lambda: term)
    stepper = Stepper(
        cascade, knowledge, TIMING, smooth_dynamics(vehicle), trim, period.terms, term[0], features=features
    )
    return period, stepper, point, close_terms(point.step.loops, term)


def differences(f, at, steps):
    """Central differences (rows, columns) of a function by each component."""
    columns = []
    for i, step in enumerate(steps):
        ahead, behind = at.copy(), at.copy()
        ahead[i] += step
        behind[i] -= step
        columns.append((f(ahead) - f(behind)) / (2.0 * step))
    return np.array(columns).T


DESIGNS = [
    (("ladrc", "hybrid"), "gyro, lag-aware", "hover"),
    (("ladrc", "hybrid"), "delayed", "turned in wind"),
    (("pid", "adrc"), "observer rates", "forward"),
    (("pid", "adrc"), "delayed", "attitude"),
    (("hybrid_gsta", "supertwisting"), "observer rates", "turned in wind"),
    (("hybrid_gsta", "supertwisting"), "gyro, lag-aware", "attitude"),
    (("adrc", "hybrid_true_sta"), "delayed", "hover"),
]


@pytest.mark.parametrize(("pair", "option", "name"), DESIGNS)
def test_derivatives_are_those_of_plain_python(pair, option, name):
    trim, options = TRIMS[name], OPTIONS[option]
    gains = default_gains(*pair)[None]
    _, stepper, point, closed = linearised(pair, trim, options, gains)
    assert point.steady.all()
    names = paths(stepper.state)
    # Limits take nothing away in a trim; the rounding errors in their place would be taken for saturation.
    clipped = np.array(["excess" in name for name in names])
    x = np.where(clipped, 0.0, point.state[0])
    # Steps of 1e-6 of each state's size: a truncation of 1e-12 and a rounding of 1e-10 of the rows' scale.
    size = 1e-6 * np.maximum(np.abs(x), 1.0)

    by_state = differences(lambda state: stepper.injected(state, gains[0], np.zeros(6)), x, size)
    by_signal = differences(lambda v: stepper.injected(x, gains[0], v), np.zeros(6), np.full(6, 1e-5))
    rows = np.r_[closed.command, closed.output]
    exact_state = np.concatenate([closed.a[0], closed.c[0][rows]])
    exact_signal = np.concatenate([closed.b[0], closed.d[0][rows]])[:, closed.injected]
    kept = np.concatenate([~clipped, np.ones(len(rows), dtype=bool)])
    for found, exact in (
        (by_state[kept][:, ~clipped], exact_state[kept][:, ~clipped]),
        (by_signal[kept], exact_signal[kept]),
    ):
        scale = np.maximum(np.abs(exact).max(axis=1, keepdims=True), 1.0)
        np.testing.assert_allclose(found / scale, exact / scale, rtol=0.0, atol=1e-7)


@pytest.mark.parametrize("name", LAWS)
def test_blocks_have_the_poles_and_responses_of_the_whole(name):
    gains = random_gains(name, name, 1, 4)
    for trim in (TRIMS["hover"], TRIMS["attitude"]):
        period, stepper, point, closed = linearised((name, name), trim, ControlOptions(), gains)
        blocks = blocks_of(closed, coordinates(period, HUMMINGBIRD, point.state[0]))
        assert sorted(c for block in blocks for c in block.channels) == (
            [0, 1, 2, 3, 4, 5] if trim.hold else [2, 3, 4, 5]
        )
        parts = [block.part(closed) for block in blocks]
        for i in range(len(gains)):
            for z in (0.6 + 0.5j, 1.2 - 0.1j, -0.9 + 0.4j):
                whole = (
                    closed.c[i] @ np.linalg.solve(z * np.eye(len(closed.a[i])) - closed.a[i], closed.b[i]) + closed.d[i]
                )
                for block, part in zip(blocks, parts, strict=True):
                    own = part.c[i] @ np.linalg.solve(z * np.eye(len(part.a[i])) - part.a[i], part.b[i]) + part.d[i]
                    channels = list(block.channels)
                    wanted = whole[closed.command, closed.injected][np.ix_(channels, channels)]
                    got = own[part.command, part.injected]
                    np.testing.assert_allclose(got, wanted, rtol=0.0, atol=1e-8 * np.abs(np.diag(wanted)).max())
            if trim.hold:
                poles = np.linalg.eigvals(closed.a[i])
                for part in parts:
                    for pole in np.linalg.eigvals(part.a[i]):
                        # A triple pole is known to the third root of rounding only.
                        assert np.abs(poles - pole).min() < 3e-5


@pytest.mark.parametrize("vehicle", ["hummingbird", "crazyflie-pybullet"])
def test_hover_falls_into_the_known_cascades(vehicle):
    model = model_of("ladrc", "ladrc", vehicle=load(vehicle).vehicle)
    assert model.blocks == (("x", "pitch"), ("y", "roll"), ("z",), ("yaw",))
    turned = model_of("ladrc", "ladrc", trim=Trim(yaw=0.5 * np.pi), vehicle=load(vehicle).vehicle)
    assert turned.blocks == (("x", "roll"), ("y", "pitch"), ("z",), ("yaw",))


STILL = Vec3(0.0, 0.0, 0.0)


def fly(stepper, state, gains, steps, velocity=STILL):
    """State after a number of periods; the set point moves at a velocity."""
    for k in range(steps):
        t = k * H
        at = Vec3(velocity.x * t, velocity.y * t, velocity.z * t)
        state, _, _ = stepper.step(state.tolist(), gains.tolist(), reference=stepper.reference(at, velocity))
    return state


@pytest.mark.parametrize("pair", [("pid", "hybrid"), ("hybrid_paper_f_hat", "ladrc")], ids="-".join)
def test_flight_stays_in_its_trim(pair):
    gains = default_gains(*pair)[None]
    heavier = vary(HUMMINGBIRD, 1.1, 0.9, 0.95, 1.1)
    _, stepper, point, _ = linearised(pair, WINDY, OPTIONS["delayed"], gains, heavier)
    stepper.gain = None
    after = fly(stepper, point.state[0], gains[0], 100)
    assert point.steady.all()
    np.testing.assert_allclose(after, point.state[0], rtol=1e-7, atol=1e-7)


def test_moving_through_still_air_is_holding_a_place_in_wind():
    """Flying at 3 m/s after a moving set point, attitude, rates and rotors stay those of the trim that holds a place."""
    velocity = Vec3(3.0, 0.0, 0.0)
    gains = default_gains("ladrc", "ladrc")[None]
    _, stepper, point, _ = linearised(("ladrc", "ladrc"), Trim(velocity=velocity), ControlOptions(), gains)
    stepper.disturbance = stepper.disturbance._replace(wind=Vec3(0.0, 0.0, 0.0))
    names = paths(stepper.state)
    start = point.state[0].copy()
    start[names.index("body.velocity.x")] += velocity.x
    start[names.index("control.x.z2")] += velocity.x
    # The observer's place is that of one period ago.
    start[names.index("control.x.z1")] -= velocity.x * H
    after = fly(stepper, start, gains[0], 250, velocity)
    same = [i for i, name in enumerate(names) if name.startswith(("body.attitude", "body.rate", "body.rotor"))]
    np.testing.assert_allclose(after[same], point.state[0][same], rtol=1e-9, atol=1e-9)


def test_a_trim_beyond_the_tilt_limit_is_refused():
    knowledge = nominal(HUMMINGBIRD, ControlOptions(), H)
    gale = Trim(wind=Vec3(30.0, 0.0, 0.0))
    with pytest.raises(InputError, match="air flow of 30 m/s within the limits of tilt"):
        balanced_plant(
            PeriodMap(cascade_of("pid", "pid"), TIMING), gale, knowledge, setting_of(gale, knowledge, HUMMINGBIRD)
        )
    with pytest.raises(InputError, match="attitude mode"):
        Trim(wind=Vec3(1.0, 0.0, 0.0), hold=False)


def test_a_rotor_with_two_time_constants_acts_on_small_oscillations_as_its_mean_pole_says():
    """First harmonic of the rotor's own response to a sine, by Fourier integral of a simulation."""
    rise, fall, w = 80.0, 40.0, 30.0
    n, cycles = 4000, 12
    dt = 2.0 * np.pi / w / n
    x, trace = 0.0, []
    for k in range(n * cycles):
        error = np.sin(w * (k + 0.5) * dt) - x
        x += dt * error * (rise if error > 0.0 else fall)
        trace.append(x)
    t = w * dt * (np.arange(n) + 1.0)
    harmonic = 2.0 * np.mean(np.array(trace[-n:]) * np.exp(-1j * t), axis=0) * 1j
    pole = mean_pole(rise, fall)
    # The harmonics that a describing function neglects are left: a quarter of what the plain mean of the poles is wrong by.
    assert abs(harmonic - pole / (1j * w + pole)) < 0.25 * abs(harmonic - 60.0 / (1j * w + 60.0))
    assert mean_pole(50.0, 50.0) == pytest.approx(50.0)
