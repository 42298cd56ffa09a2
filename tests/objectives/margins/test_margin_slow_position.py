"""Position loops that wait: against python-control, the attitude loop closed at its own rate and seen at theirs."""

from typing import Any

import control
import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from objectives.margins.describing import Case
from objectives.margins.linearise import one_period
from objectives.margins.margins import MarginModel
from objectives.margins.period import period_map
from objectives.margins.quantities import LIMITABLE
from objectives.margins.requirement import MarginRequirement
from objectives.margins.slow_position import slow_position
from objectives.margins.trim import Trim, balanced_plant, setting_of
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.features import vehicle_features
from plant.quadrotor.gains import default_row, gain_addresses
from plant.quadrotor.nominal import ControlOptions, Nominal, nominal
from plant.vectors import Vec3
from tests.objectives.margins.designs import HUMMINGBIRD, ideal_vehicle
from tests.objectives.margins.python_control import Loop, classical

LAG, GRAVITY = 0.03, HUMMINGBIRD.gravity
VEHICLE = ideal_vehicle(LAG)
X, Z, PITCH = 0, 2, 4


def model_of(h: float, every: int, position: str = "pid") -> MarginModel:
    cascade = close_cascade(LAWS[position], LAWS["pid"], every)
    return MarginModel(cascade, model_nominal(h), Timing(h, h), VEHICLE, cases=(Case(0.3),))


def model_nominal(h: float) -> Nominal:
    return nominal(VEHICLE, ControlOptions(), h)


def gains_with(model: MarginModel, **changed: float) -> np.ndarray:
    row = np.array(default_row(model.cascade))
    for gain in gain_addresses(model.cascade):
        row[gain.column] = changed.get(gain.address.replace(".", "__"), row[gain.column])
    return row


def by_axis(model: MarginModel, row: np.ndarray, axis: str) -> dict[str, float]:
    return {gain.info.name: row[gain.column] for gain in gain_addresses(model.cascade) if gain.axis == axis}


def sampled(a: np.ndarray, b: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    """Return A and B of an input that is held."""
    whole = expm(h * np.block([[a, b], [np.zeros((1, len(a) + 1))]]))
    return whole[:-1, :-1], whole[:-1, -1:]


def tilting(gains: dict[str, float], h: float, factor: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Return A and B, from the tilt asked for, of acceleration, rate and angle, speed and place, and the attitude's PID.

    factor: on the torque that the PID asks for.
    """
    a = np.diag([1.0, 1.0, GRAVITY, 1.0], -1)
    a[0, 0] = -1.0 / LAG
    ad, bd = sampled(a, factor * np.array([[1.0 / LAG], *[[0.0]] * 4]), h)
    share = 1.0 - np.exp(-h / gains["t_f"])
    kept = (1.0 - share) * gains["kd"]
    # Rows of the command: acceleration, rate, angle, speed, place, integral, filtered rate.
    command = np.array([0.0, -share * gains["kd"], -gains["kp"], 0.0, 0.0, 1.0, -kept])
    whole = np.zeros((7, 7))
    whole[:5, :5] = ad
    whole[:5] += bd @ command[None]
    whole[5, 5], whole[5, 2] = 1.0, -h * gains["ki"]
    whole[6, 6], whole[6, 1] = 1.0 - share, share
    return whole, np.concatenate([bd * gains["kp"], [[h * gains["ki"]], [0.0]]])


def lifting(h: float) -> tuple[np.ndarray, np.ndarray]:
    """Return A and B, from the lift asked for, of acceleration, speed and place."""
    a = np.diag([1.0, 1.0], -1)
    a[0, 0] = -1.0 / LAG
    return sampled(a, np.array([[1.0 / LAG], [0.0], [0.0]]), h)


def over(a: np.ndarray, b: np.ndarray, every: int) -> tuple[np.ndarray, np.ndarray]:
    """Return A and B over so many periods with the input held."""
    powers = [np.linalg.matrix_power(a, i) for i in range(every + 1)]
    return powers[every], np.sum([power @ b for power in powers[:every]], axis=0)


def loop_of(model: MarginModel, row: np.ndarray, channel: int, every: int) -> Any:
    """Return the loop transfer function of a position channel, sampled as often as it steps."""
    h = model.control_period
    if channel == Z:
        a, b, (speed, place), unit = *lifting(h), (1, 2), 1.0
    else:
        a, b, (speed, place), unit = *tilting(by_axis(model, row, "pitch"), h), (3, 4), 1.0 / GRAVITY
    a, b = over(a, b, every)
    rows = np.eye(len(a))
    moving, standing = (control.ss(a, unit * b, rows[[part]], 0.0, every * h) for part in (speed, place))
    gains, period = by_axis(model, row, "xyz"[channel]), every * h
    share = 1.0 - np.exp(-period / gains["t_f"])
    return lambda z: (
        (gains["kp"] + gains["ki"] * period / (z - 1.0)) * standing(z)
        + gains["kd"] * share / (1.0 - (1.0 - share) / z) * moving(z)
    )


@pytest.mark.parametrize(("h", "every"), [(0.002, 5), (0.004, 25)])
@pytest.mark.parametrize("channel", [X, Z], ids=["x", "z"])
def test_margins_are_those_of_python_control_at_their_own_period(h: float, every: int, channel: int) -> None:
    model = model_of(h, every)
    row = gains_with(model, x__kp=1.2, x__ki=0.2)
    found = model.evaluate(row[None])
    top = np.pi / (every * h)
    loop = Loop(loop_of(model, row, channel, every), every * h, np.geomspace(1e-2, top, 500))
    assert found.stable[0, channel]
    for what, wanted in classical(loop).items():
        assert getattr(found, what).value[0, channel] == pytest.approx(wanted, rel=2e-6), what
    peak = 1.0 / loop.least(lambda value: np.abs(1.0 + value))
    assert found.sensitivity.value[0, channel] == pytest.approx(peak, rel=2e-6)
    w = np.geomspace(0.1, 0.9 * top, 20)
    expected = np.array([loop(at) for at in w])
    np.testing.assert_allclose(model.loop(row, "xyz"[channel], frequency=w).loop, expected, rtol=2e-6, atol=2e-8)
    curves = model.curves(row[None], np.zeros((1, 6), dtype=int), w)
    np.testing.assert_allclose(curves[0, channel], expected, rtol=2e-6, atol=2e-8)


def test_a_loop_that_its_wait_makes_unstable_has_no_margin_and_nor_has_the_attitude_inside() -> None:
    """Gains that are stable while every period counts and not at every 25th; the poles are those of the closed monodromy."""
    swift, slow = model_of(0.004, 1), model_of(0.004, 25)
    row = gains_with(slow, x__kp=6.0, x__kd=6.0, x__ki=0.1)
    assert swift.evaluate(row[None]).stable[0].all()
    found = slow.evaluate(row[None])
    assert not found.stable[0, [X, PITCH]].any() and found.stable[0, [Z, 1, 3, 5]].all()
    assert found.sensitivity.value[0, PITCH] == np.inf and found.growth[0, X] > 0.0
    growth = np.log(np.abs(np.linalg.eigvals(monodromy(slow, row, 25))).max(axis=0)) / 0.1
    assert found.growth[0, X] == pytest.approx(growth, rel=1e-6)


def monodromy(model: MarginModel, row: np.ndarray, every: int, factor: float = 1.0) -> np.ndarray:
    """Return the closed loop of x and pitch over a common period, the command of pitch multiplied by a factor."""
    period = every * model.control_period
    a, b = over(*tilting(by_axis(model, row, "pitch"), model.control_period, factor), every)
    gains = by_axis(model, row, "x")
    share = 1.0 - np.exp(-period / gains["t_f"])
    command = np.zeros(9)
    command[[3, 4, 7, 8]] = -share * gains["kd"], -gains["kp"], 1.0, -(1.0 - share) * gains["kd"]
    whole = np.block([[a, np.zeros((7, 2))], [np.zeros((2, 9))]])
    whole[:7] += b @ command[None] / GRAVITY
    whole[7, [4, 7]], whole[8, [3, 8]] = (-period * gains["ki"], 1.0), (share, 1.0 - share)
    return whole


# Fourth-order steps of the plant are off the exponential by (h/LAG)^5/120 each.
@pytest.mark.parametrize(("h", "every", "off"), [(0.002, 5, 2e-6), (0.004, 12, 3e-5)])
def test_the_gain_margins_of_an_attitude_loop_are_where_a_pole_of_the_common_period_leaves_the_circle(
    h: float, every: int, off: float
) -> None:
    """As `evaluate` and exact limits have them; limits of a search, which take the wait for none, are a little off."""
    model = model_of(h, every)
    row = gains_with(model, x__kp=3.0, x__ki=0.5, x__kd=2.5)
    margins = model.evaluate(row[None])
    assert margins.stable.all()

    def outside(level: float) -> float:
        poles = np.linalg.eigvals(monodromy(model, row, every, float(np.exp(level))))
        return float(np.abs(poles).max()) - 1.0

    def root_of(low: float, high: float) -> float:
        return float(brentq(outside, low, high, xtol=1e-13))  # pyright: ignore[reportArgumentType]

    ends = {"gain_up": (0.01, 4.0), "gain_down": (-6.0, -0.01)}
    expected = {what: np.exp(abs(root_of(*span))) for what, span in ends.items()}
    for what, factor in expected.items():
        assert getattr(margins, what).value[0, PITCH] == pytest.approx(factor, rel=off), what
    limit = MarginRequirement(LIMITABLE["gain_up"], "gain_up", ("pitch",), 6.0)
    exact = MarginModel(model.flown, model_nominal(h), Timing(h, h), VEHICLE, cases=(Case(0.3),), exact=True)
    decibels = 20.0 * np.log10(expected["gain_up"])
    assert exact.limited(row[None], [limit])[0, 0] == pytest.approx(decibels, rel=off)
    searched = model.limited(row[None], [limit])[0, 0]
    assert 1e-5 < abs(searched / decibels - 1.0) < 0.03


def test_the_curve_of_an_attitude_loop_is_the_part_of_its_command_at_the_frequency_injected() -> None:
    """Against the two loops stepped by hand, x once in five periods, until a sine on the torque of pitch comes back steadily."""
    h, every = 0.002, 5
    model = model_of(h, every)
    row = gains_with(model, x__kp=3.0, x__ki=0.5, x__kd=2.5)
    inner, outer = by_axis(model, row, "pitch"), by_axis(model, row, "x")
    a, b = tilting(inner, h)
    free = np.diag([1.0, 1.0, GRAVITY, 1.0], -1)
    free[0, 0] = -1.0 / LAG
    _, pushed = sampled(free, np.array([[1.0 / LAG], *[[0.0]] * 4]), h)
    share, slow = 1.0 - np.exp(-h / inner["t_f"]), 1.0 - np.exp(-every * h / outer["t_f"])
    command = np.array([0.0, -share * inner["kd"], -inner["kp"], 0.0, 0.0, 1.0, -(1.0 - share) * inner["kd"]])
    w = np.array([2.0, 9.0, 40.0, 200.0])
    x, integral, rate, tilt, seen = np.zeros((7, 4), complex), 0.0, 0.0, 0.0, []
    for k in range(40_000):
        if k % every == 0:
            rate = rate + slow * (x[3] - rate)
            tilt = (-outer["kp"] * x[4] + integral - outer["kd"] * rate) / GRAVITY
            integral = integral - every * h * outer["ki"] * x[4]
        seen.append((command @ x + inner["kp"] * tilt) * np.exp(-1j * w * k * h))
        x = a @ x + b * tilt
        x[:5] += pushed * np.exp(1j * w * k * h)
    expected = np.mean(seen[-every:], axis=0)
    np.testing.assert_allclose(model.loop(row, "pitch", Case(0.3), w).t, expected, rtol=1e-4)


@pytest.mark.parametrize("name", ["px4_position", "hybrid"])
def test_waiting_costs_phase_as_a_delay_does(name: str) -> None:
    """Half of what it waits longer, to first order in the wait, for laws with filters, observers and nonlinear terms."""
    h, every = 0.0005, 4
    prompt, late = (model_of(h, n, name) for n in (1, every))
    row = gains_with(prompt)
    before, after = prompt.evaluate(row[None]), late.evaluate(row[None])
    assert after.stable[0].all()
    for channel in (X, Z):
        crossover = before.crossover.value[0, channel]
        lost = before.phase.value[0, channel] - after.phase.value[0, channel]
        assert abs(lost) < 4.0 * crossover * every * h
    np.testing.assert_allclose(after.phase.value[0, 3:], before.phase.value[0, 3:], rtol=2e-3)
    assert after.phase.value[0, 5] == before.phase.value[0, 5], "nothing waits around the heading"


def test_without_the_place_held_nothing_waits_but_the_height() -> None:
    cascade = close_cascade(LAWS["pid"], LAWS["pid"], 5)
    known = nominal(VEHICLE, ControlOptions(), 0.002)
    model = MarginModel(cascade, known, Timing(0.002, 0.002), VEHICLE, Trim(hold=False))
    prompt = MarginModel(cascade.at_one_rate, known, Timing(0.002, 0.002), VEHICLE, Trim(hold=False))
    row = gains_with(model)[None]
    found, usual = model.evaluate(row), prompt.evaluate(row)
    assert found.phase.value[0, 3:].tolist() == usual.phase.value[0, 3:].tolist()
    assert found.phase.value[0, Z] < usual.phase.value[0, Z]


def test_turned_by_yaw_the_loops_are_the_same() -> None:
    """Off the axes of the world x and y are one block, each with the other closed around it."""
    inertia = VEHICLE.inertia
    round_one = VEHICLE._replace(inertia=inertia._replace(y=inertia.x))
    cascade, known = close_cascade(LAWS["pid"], LAWS["pid"], 5), nominal(round_one, ControlOptions(), 0.002)
    ahead, turned = (MarginModel(cascade, known, Timing(0.002, 0.002), round_one, Trim(yaw=yaw)) for yaw in (0.0, 0.6))
    assert ("x", "pitch") in ahead.blocks and ("x", "y", "roll", "pitch") in turned.blocks
    row = gains_with(ahead)[None]
    for what in ("phase", "gain_up", "sensitivity", "delay"):
        one, two = (getattr(model.evaluate(row), what).value[0, :2] for model in (ahead, turned))
        np.testing.assert_allclose(two, one, rtol=1e-6)


def test_a_common_period_of_steady_flight_in_wind_ends_where_it_began() -> None:
    """Flown period by period, the position loops step once and wait; an observer that is handed another effect would drift."""
    every, timing = 4, Timing(0.002, 0.002)
    cascade, known = close_cascade(LAWS["ladrc"], LAWS["pid"], every), nominal(HUMMINGBIRD, ControlOptions(), 0.002)
    fitted = vehicle_features(HUMMINGBIRD, timing.control_period)
    trim = Trim(wind=Vec3(4.0, 2.0, 0.0))
    setting = setting_of(trim, known, HUMMINGBIRD)
    plant = balanced_plant(period_map(cascade.at_one_rate, timing, fitted), trim, known, setting)
    slow, gains = slow_position(cascade, timing, fitted), np.array(default_row(cascade))[None]
    terms = np.zeros((1, len(slow.flown.terms)))
    flight = slow.at(gains, setting, plant, lambda: terms)
    state = flight.state
    for _ in range(every):
        state = one_period(slow.flown, state, terms, gains, setting, plant).state
    tilt = flight.state[0, 7:9]
    assert flight.steady.all() and np.hypot(*tilt) > 0.02, "the wind tilts it"
    np.testing.assert_allclose(state, flight.state, rtol=1e-7, atol=1e-7)


@pytest.mark.slow
def test_no_gain_margin_is_missed_where_small_eigenvalues_come_and_go():
    """Lifted loops have eigenvalues near 0 whose signs are rounding; one that came to it hid a crossing in the same cell."""
    vehicle = load("racer5").vehicle
    cascade = close_cascade(LAWS["pid"], LAWS["betaflight"], 16)
    known = nominal(vehicle, ControlOptions(), 0.00025)
    model = MarginModel(cascade, known, Timing(0.00025, 0.00025), vehicle, cases=(Case(0.3),))
    columns = {gain.address: gain.column for gain in gain_addresses(cascade)}
    rows = np.tile(default_row(cascade, vehicle), (21, 1))
    rows[:, columns["roll.p"]] = np.linspace(60.0, 70.0, len(rows))
    rows[:, columns["roll.i"]] = 1.77 * rows[:, columns["roll.p"]]
    margins = model.evaluate(rows).gain_up.value[:, 3]
    assert np.all(np.isfinite(margins)) and np.all(np.diff(margins) < 0.0)
