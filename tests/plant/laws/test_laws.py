"""The contract of a control law, run on every law of the registry in both loops: a new law inherits all of it."""

from itertools import product
from math import hypot
from typing import Any

import numpy as np
import pytest

from plant.backends.rebind import PRIMITIVES, Rebinder
from plant.backends.stepping import fly_steps, unchanged
from plant.closed_loop import Status
from plant.errors import UnknownNameError
from plant.laws import LAWS, Law, Nonlinearity, law
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.law import HELD_COMMAND, PROMISES
from plant.loop import Timing
from plant.nominal import ControlOptions, nominal
from plant.records import flatten
from tests.plant.axis import LOOPS, REST, Axis, H, Input, defaults, random_inputs, run
from tests.plant.harness import (
    HUMMINGBIRD,
    LIMITS,
    TARGETS,
    Array,
    batch,
    default_gains,
    loop_of,
    references,
    scenario,
)

each_law = pytest.mark.parametrize("entry", LAWS.values(), ids=LAWS)
each_loop = pytest.mark.parametrize("loop", LOOPS)
each_nonlinearity = pytest.mark.parametrize(
    ("entry", "nonlinearity"),
    [(entry, nonlinearity) for entry in LAWS.values() for nonlinearity in entry.nonlinear],
    ids=[f"{entry.name}-{nonlinearity.name}" for entry in LAWS.values() for nonlinearity in entry.nonlinear],
)
each_observer = pytest.mark.parametrize(
    "entry",
    [entry for entry in LAWS.values() if entry.observer is not None],
    ids=[entry.name for entry in LAWS.values() if entry.observer is not None],
)
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
    assert entry.promises <= PROMISES
    assert len({other.title for other in LAWS.values()}) == len(LAWS)


@each_law
def test_it_tells_how_it_is_sampled_and_what_proofs_need(entry: Law) -> None:
    assert entry.sampling and "\n" not in entry.discretisation and entry.discretisation.endswith(HELD_COMMAND)
    kin = next(other for other in LAWS.values() if other.family == entry.family)
    assert not entry.family or kin.Gains._fields == entry.Gains._fields
    assert entry.sector is None or entry.continuous is not None
    if entry.super_twisting is not None:
        named = {entry.super_twisting.k1, entry.super_twisting.k2, entry.super_twisting.mu or entry.super_twisting.k1}
        assert named <= set(entry.Gains._fields)


@each_observer
def test_the_continuous_observer_is_the_sampled_one_in_the_limit(entry: Law) -> None:
    assert entry.observer is not None
    omega_o, h = 10.0, 1e-6
    sampled = entry.prepare(defaults(entry, "attitude")._replace(omega_o=omega_o), h).observer
    np.testing.assert_allclose(np.array(sampled) / h, entry.observer(omega_o), rtol=1e-4)


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
    memory = entry.start(constants, Measured(place, 0.0), 0.0)
    arrived, here = Setpoint(place, 0.0, 0.0), Measured(place, 0.0)
    command, after = entry.step(memory, constants, Channel(2.0, float(from_observer)), arrived, here, STILL, H)
    assert command == 0.0
    assert after == memory


@each_law
@each_loop
@each_rate
def test_command_points_at_the_setpoint_and_against_the_motion(entry: Law, loop: str, from_observer: bool) -> None:
    constants = entry.prepare(defaults(entry, loop), H)
    memory = entry.start(constants, Measured(0.0, 0.0), 0.0)
    channel = Channel(2.0, float(from_observer))
    for sign in (1.0, -1.0):
        ahead, _ = entry.step(memory, constants, channel, Setpoint(0.1 * sign, 0.0, 0.0), Measured(0.0, 0.0), STILL, H)
        pushed, _ = entry.step(memory, constants, channel, Setpoint(0.0, 0.0, 0.1 * sign), Measured(0.0, 0.0), STILL, H)
        assert ahead * sign > 0.0
        # What does not follow an acceleration need not be pushed by it, what does not come to rest need not brake.
        assert pushed * sign > 0.0 or "tracks" not in entry.promises
        moving = entry.start(constants, Measured(0.0, 0.1 * sign), 0.0)
        braking, _ = entry.step(moving, constants, channel, REST, Measured(0.0, 0.1 * sign), STILL, H)
        assert braking * sign < 0.0 or "rejects" not in entry.promises


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
    """Feedforward: the acceleration asked for is commanded and no more, filters of the law aside; or it is not promised.

    A held command flies piecewise constant acceleration exactly. Started a nanometre beside it, the error may not grow,
    and the command departs by no more than gains of 1e4 make of that.
    """
    gains, beside = defaults(entry, loop), 1e-9
    gains = gains._replace(t_f=0.0) if "t_f" in gains._fields else gains
    plan = [1.0, -1.0, -0.5, 0.5]
    path = [Setpoint(0.2, 0.0, plan[0])]
    for k in range(400):
        y, v, a = path[-1]
        path.append(Setpoint(y + H * v + 0.5 * H * H * a, v + H * a, plan[(k + 1) // 101]))
    flown = Axis(b0=4.0).fly(entry, gains, 401, lambda t: path[round(t / H)], Measured(0.2 + beside, 0.0))
    away = np.abs(flown.value - [point.value for point in path]).max(axis=0)
    extra = np.abs(4.0 * flown.command - [point.acceleration for point in path]).max(axis=0)
    assert (away < 1.1 * beside and extra < 1e4 * beside) == ("tracks" in entry.promises)


# Slowest closed-loop pole with default gains: PID ki/kp = 1 and 0.24 1/s, the sliding surface 1 1/s: 120 s leave
# exp(-28) of 2 m.
@each_law
@each_loop
@each_rate
def test_a_constant_disturbance_leaves_no_error(entry: Law, loop: str, from_observer: bool) -> None:
    """To 1e-9 and with the command at rest, throughout the last second; or it is not promised."""
    axis = Axis(b0=2.0, disturbance=0.7, from_observer=from_observer)
    flown = axis.fly(entry, defaults(entry, loop), 12000, lambda t: Setpoint(1.0, 0.0, 0.0), h=0.01)
    assert np.abs(flown.value - 1.0).max(axis=0) > 0.9
    error = np.abs(flown.value[-100:] - 1.0).max(axis=0)
    unrest = np.abs(flown.command[-100:] + 0.7).max(axis=0)
    assert (error < 1e-9 and unrest < 1e-7) == ("rejects" in entry.promises)


def settling(value: Array) -> float:
    """Time [s] from which on a step to 1 stays within 2 %."""
    return H * float(np.nonzero(np.abs(value - 1.0) > 0.02)[0][-1] + 1)


@each_law
@each_loop
def test_what_is_told_of_saturation_keeps_the_response_short(entry: Law, loop: str) -> None:
    """A step that asks for ten times the limit: little more overshoot than without, and no tail; told nothing, it winds up."""
    gains, goal, duration = defaults(entry, loop), lambda t: Setpoint(1.0, 0.0, 0.0), 30.0
    limit = 0.1 * float(np.abs(Axis().fly(entry, gains, 250, goal).asked).max(axis=0))
    free, told, untold = (
        Axis(limit=bound, told=hears).fly(entry, gains, round(duration / H), goal)
        for bound, hears in ((np.inf, "all"), (limit, "all"), (limit, "nothing"))
    )
    if settling(free.value) == duration:
        assert "rejects" not in entry.promises  # what never settles cannot settle late
        return
    assert np.abs(told.command).max(axis=0) == limit
    # No command within the limit reaches 1 at rest sooner than full ahead for half the way and full astern for the
    # rest.
    soonest = 2.0 * float(np.sqrt(1.0 / limit))
    assert settling(told.value) < settling(free.value) + soonest
    # Braking is limited too: a law that asks for lambda^2 e to brake as it arrives overshoots where the limit is less.
    assert told.value.max(axis=0) < free.value.max(axis=0) + 0.3
    assert untold.value.max(axis=0) > told.value.max(axis=0) + 0.2


@each_nonlinearity
@each_loop
def test_what_depends_on_amplitude_is_an_odd_function(entry: Law, nonlinearity: Nonlinearity, loop: str) -> None:
    constants = entry.prepare(defaults(entry, loop), H)
    sizes = np.geomspace(1e-9, 1e3, 200).tolist()
    values = np.array([nonlinearity.function(s, constants) for s in sizes])
    mirrored = np.array([nonlinearity.function(-s, constants) for s in sizes])
    np.testing.assert_array_equal(mirrored, -values)
    assert nonlinearity.function(0.0, constants) == 0.0
    assert (values > 0.0).all()
    gains = values / sizes
    assert np.ptp(gains, axis=0) > 0.1 * gains.max(axis=0)  # otherwise it would be linear
    assert nonlinearity.unit.startswith("{y}") and "{" not in nonlinearity.unit_in(loop)


def feedback(entry: Law, loop: str, from_observer: bool, linear: bool, inputs: Array) -> Array:
    """Commands (K,) for y, rate and effect (K, 3) about rest, unsaturated; linear: with k s for each nonlinearity."""
    stand_ins = {part.function: lambda s, constants, k=k: k * s for k, part in enumerate(entry.nonlinear, 2)}
    step = Rebinder(PRIMITIVES, stand_ins=stand_ins if linear else None)(entry.step)
    constants = entry.prepare(defaults(entry, loop), H)
    memory, channel = entry.start(constants, Measured(0.0, 0.0), 0.0), Channel(1.0, float(from_observer))
    commands = []
    for value, rate, effect in inputs.tolist():
        command, memory = step(memory, constants, channel, REST, Measured(value, rate), Applied(effect, 0.0), H)
        commands.append(command)
    return np.array(commands)


@each_law
@each_loop
@each_rate
def test_nothing_but_what_is_named_depends_on_amplitude(entry: Law, loop: str, from_observer: bool) -> None:
    """With a gain in place of each function named, signals 2^20 times as large give commands 2^20 times as large, to the
    last bit, and sums of signals sums of commands; as it stands, a law that names one does not scale.
    """
    rng, large = np.random.default_rng(4), 2.0**20
    first, second = 1e-3 * rng.standard_normal((2, 60, 3))

    def respond(signals: Array, linear: bool = True) -> Array:
        return feedback(entry, loop, from_observer, linear, signals)

    alone = respond(first)
    assert np.abs(alone).min(axis=0) > 0.0
    np.testing.assert_array_equal(respond(large * first), large * alone)
    together = respond(first + second)
    size = np.abs(together).max(axis=0)
    np.testing.assert_allclose(together, alone + respond(second), rtol=0.0, atol=1e-9 * size)
    scales = np.array_equal(respond(large * first, linear=False), large * respond(first, linear=False))
    assert scales == (not entry.nonlinear)


@each_law
def test_default_gains_hold_the_hummingbird_through_a_blow(entry: Law) -> None:
    """Hit for 0.4 s by 2 m/s2 sideways and 8 rad/s2 in roll and pitch, a law that rejects disturbances has it level and on
    its way back 3 s later. RK4 at 4 ms is accurate to 1e-4 here, with rotor lags of 20 ms.
    """
    loop, steps = loop_of(entry.name, entry.name), round(3.4 / H)
    air = np.zeros((1, steps, 12))
    air[0, :100, 6:8], air[0, :100, 9:11] = 2.0, 8.0
    inputs = scenario(batch([HUMMINGBIRD], air, np.zeros((1, steps, 12)), references(steps)), 0)
    know = nominal(HUMMINGBIRD, ControlOptions(), H)
    deviations: list[tuple[float, float]] = []

    def watch(k: int, flight: Any) -> None:
        place, q = flight.body.position, flight.body.attitude
        deviations.append((hypot(place.x, place.y, place.z), 2.0 * hypot(q.x, q.y)))

    flown = fly_steps(loop, unchanged, default_gains(loop), know, inputs, TARGETS, LIMITS, Timing(H, H), watch)
    away, leaning = np.array(deviations).T
    assert 0.05 < away.max(axis=0) and 0.05 < leaning.max(axis=0)
    held = flown.status == Status.COMPLETED.code and away.max(axis=0) < 1.0 and leaning.max(axis=0) < 0.6
    recovering = away[-1] < 0.5 * away.max(axis=0) and leaning[-1] < 0.1
    assert (held and recovering) or "rejects" not in entry.promises
