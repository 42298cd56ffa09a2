"""The contract of a control law, run on every law of the registry in both loops: a new law inherits all of it."""

from itertools import product

import numpy as np
import pytest

from plant.errors import UnknownNameError
from plant.laws import LAWS, Law, law
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.records import flatten
from tests.plant.axis import LOOPS, REST, Axis, H, Input, defaults, random_inputs, run
from tests.plant.harness import Array

each_law = pytest.mark.parametrize("entry", LAWS.values(), ids=LAWS)
each_loop = pytest.mark.parametrize("loop", LOOPS)
each_rate = pytest.mark.parametrize("from_observer", [False, True], ids=["measured", "observer"])
STILL = Applied(0.0, 0.0)


def test_a_law_is_found_by_its_name_and_a_misspelt_one_is_helped() -> None:
    assert all(law(name) is entry and entry.name == name for name, entry in LAWS.items())
    with pytest.raises(UnknownNameError, match="did you mean 'hybrid'"):
        law("hybird")


@each_law
def test_every_gain_is_described(entry: Law) -> None:
    assert tuple(gain.name for gain in entry.gains) == entry.Gains._fields
    assert len({gain.symbol for gain in entry.gains}) == len(entry.gains)
    for gain in entry.gains:
        assert gain.scale in ("log", "linear")
        assert all((gain.symbol, gain.unit, gain.meaning, gain.source))
        assert "{" not in gain.unit_in("attitude") + gain.unit_in("position")
    assert entry.title and entry.source


@each_law
@each_loop
def test_ranges_hold_their_defaults_and_keep_to_what_is_meaningful(entry: Law, loop: str) -> None:
    for gain in entry.gains:
        span = gain.span(loop)
        assert span.low <= span.default <= span.high
        assert span.low < span.high
        assert span.low > gain.least if gain.exclusive else span.low >= gain.least
        assert span.low > 0.0 or gain.scale == "linear"
    assert entry.defaults(loop) == {gain.name: gain.span(loop).default for gain in entry.gains}


@each_law
@each_loop
@each_rate
@pytest.mark.parametrize("place", [0.0, 1.7, -300.0])
def test_at_rest_without_error_nothing_is_commanded_and_nothing_changes(
    entry: Law, loop: str, from_observer: bool, place: float
) -> None:
    constants = entry.prepare(defaults(entry, loop), H)
    memory = entry.start(constants, Measured(place, 0.0))
    arrived, here = Setpoint(place, 0.0, 0.0), Measured(place, 0.0)
    command, after = entry.step(memory, constants, Channel(2.0, float(from_observer)), arrived, here, STILL, H)
    assert command == 0.0
    assert after == memory


@each_law
@each_loop
@each_rate
def test_command_points_at_the_setpoint_and_against_the_motion(entry: Law, loop: str, from_observer: bool) -> None:
    constants = entry.prepare(defaults(entry, loop), H)
    memory = entry.start(constants, Measured(0.0, 0.0))
    channel = Channel(2.0, float(from_observer))
    for sign in (1.0, -1.0):
        ahead, _ = entry.step(memory, constants, channel, Setpoint(0.1 * sign, 0.0, 0.0), Measured(0.0, 0.0), STILL, H)
        pushed, _ = entry.step(memory, constants, channel, Setpoint(0.0, 0.0, 0.1 * sign), Measured(0.0, 0.0), STILL, H)
        assert ahead * sign > 0.0
        assert pushed * sign > 0.0
        moving = entry.start(constants, Measured(0.0, 0.1 * sign))
        braking, _ = entry.step(moving, constants, channel, REST, Measured(0.0, 0.1 * sign), STILL, H)
        assert braking * sign < 0.0


@each_law
@each_loop
@each_rate
def test_only_the_difference_of_reference_and_measurement_counts(entry: Law, loop: str, from_observer: bool) -> None:
    # Moved by 64, values keep 6 bits less: 1e-14 each, amplified by gains up to l3 = 1e3 in the observer and by 1/h
    # in a difference.
    inputs = random_inputs(np.random.default_rng(1), 50)
    moved = [
        Input(
            i.setpoint._replace(value=i.setpoint.value + 64.0),
            i.measured._replace(value=i.measured.value + 64.0),
            i.applied,
        )
        for i in inputs
    ]
    channel, gains = Channel(2.0, float(from_observer)), defaults(entry, loop)
    here, _ = run(entry, gains, inputs, channel)
    there, _ = run(entry, gains, moved, channel)
    assert np.ptp(here, axis=0) > 1.0
    np.testing.assert_allclose(there, here, rtol=0.0, atol=1e-11 * np.abs(here).max(axis=0))


@each_law
@each_loop
@each_rate
def test_the_command_scales_as_the_inverse_of_the_channel_gain(entry: Law, loop: str, from_observer: bool) -> None:
    """u b0 does not depend on b0 if what is delivered, in units of u, scales along; by a power of two to the last bit."""
    inputs = random_inputs(np.random.default_rng(2), 50)
    scaled = [i._replace(applied=Applied(i.applied.effect / 64.0, i.applied.excess / 64.0)) for i in inputs]
    gains = defaults(entry, loop)
    small, _ = run(entry, gains, inputs, Channel(3.0, float(from_observer)))
    large, _ = run(entry, gains, scaled, Channel(192.0, float(from_observer)))
    np.testing.assert_array_equal(small, 64.0 * large)


@each_law
@each_loop
@each_rate
def test_commands_stay_finite_at_every_corner_of_the_ranges(entry: Law, loop: str, from_observer: bool) -> None:
    inputs = random_inputs(np.random.default_rng(3), 20)
    spans = [gain.span(loop) for gain in entry.gains]
    for corner in product(*[(span.low, span.high) for span in spans]):
        commands, memory = run(entry, entry.Gains(*corner), inputs, Channel(300.0, float(from_observer)))
        assert np.isfinite(commands).all()
        assert np.isfinite(flatten(memory)).all()


@each_law
@each_loop
def test_a_reference_that_the_axis_can_fly_is_flown_without_error(entry: Law, loop: str) -> None:
    # Feedforward: the acceleration asked for is commanded and no more, filters of the law aside. A held command flies
    # piecewise constant acceleration exactly, so rounding is left: some eps a period, amplified by gains of at most
    # 1e3.
    gains = defaults(entry, loop)
    gains = gains._replace(t_f=0.0) if "t_f" in gains._fields else gains
    plan = [1.0, -1.0, -0.5, 0.5]
    path = [Setpoint(0.2, 0.0, plan[0])]
    for k in range(400):
        y, v, a = path[-1]
        path.append(Setpoint(y + H * v + 0.5 * H * H * a, v + H * a, plan[(k + 1) // 101]))
    flown = Axis(b0=4.0).fly(entry, gains, 401, lambda t: path[round(t / H)], Measured(0.2, 0.0))
    np.testing.assert_allclose(flown.value, [point.value for point in path], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(4.0 * flown.command, [point.acceleration for point in path], rtol=0.0, atol=1e-9)


# Slowest closed-loop pole with default gains: PID ki/kp = 1 and 0.24 1/s, the sliding surface 1 1/s: 120 s leave
# exp(-28) of 2 m.
@each_law
@each_loop
@each_rate
def test_a_constant_disturbance_leaves_no_error(entry: Law, loop: str, from_observer: bool) -> None:
    axis = Axis(b0=2.0, disturbance=0.7, from_observer=from_observer)
    flown = axis.fly(entry, defaults(entry, loop), round(120.0 / H), lambda t: Setpoint(1.0, 0.0, 0.0))
    assert np.abs(flown.value - 1.0).max(axis=0) > 0.9
    assert abs(flown.value[-1] - 1.0) < 1e-9
    assert flown.command[-1] == pytest.approx(-0.7, abs=1e-7)


@each_law
@each_loop
def test_what_is_told_of_saturation_keeps_the_response_short(entry: Law, loop: str) -> None:
    """A step that asks for ten times the limit: hardly more overshoot than without, and no tail; told nothing, it winds up."""
    gains, goal = defaults(entry, loop), lambda t: Setpoint(1.0, 0.0, 0.0)
    limit = 0.1 * abs(Axis().fly(entry, gains, 1, goal).asked[0])
    free, told, untold = (
        Axis(limit=bound, told=hears).fly(entry, gains, round(30.0 / H), goal)
        for bound, hears in ((np.inf, "all"), (limit, "all"), (limit, "nothing"))
    )
    assert np.abs(told.command).max(axis=0) == limit

    def settling(value: Array) -> float:
        return H * float(np.nonzero(np.abs(value - 1.0) > 0.02)[0][-1] + 1)

    # No command within the limit reaches 1 at rest sooner than full ahead for half the way and full astern for the
    # rest.
    soonest = 2.0 * float(np.sqrt(1.0 / limit))
    assert settling(told.value) < settling(free.value) + soonest
    assert told.value.max(axis=0) < free.value.max(axis=0) + 0.1
    assert untold.value.max(axis=0) > told.value.max(axis=0) + 0.2
