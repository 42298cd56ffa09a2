"""Clauses on a law's step: pure, at rest where there is nothing to do, pointing the right way, scaling, true to its description.

Every clause goes through both loops and, where it counts, through both sources of the rate; the tests of the bundled laws run
the same ones.
"""

from collections.abc import Callable, Iterator
from inspect import signature
from itertools import product
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from plant.backends.rebind import PRIMITIVES, Rebinder
from plant.contract.axis import LOOPS, REST, Array, Axis, H, Input, defaults, random_inputs, run
from plant.contract.violation import ContractViolation
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.laws.law import Law, Nonlinearity
from plant.records import flatten

STILL = Applied(0.0, 0.0)
MAX_CORNERS = 128


class Case(NamedTuple):
    """One loop with default gains, and where the rate comes from.

    changed: the gain that is not at its default, with its value.
    """

    loop: str
    from_observer: bool
    gains: Any
    changed: str = ""

    def channel(self, b0: float) -> Channel:
        """Return the channel of a gain."""
        return Channel(b0, float(self.from_observer))

    @property
    def words(self) -> str:
        """The case in words."""
        rate = "from an observer" if self.from_observer else "measured"
        return f"in the {self.loop} loop with the rate {rate}{f' and {self.changed}' if self.changed else ''}"


def cases(law: Law) -> Iterator[Case]:
    """Yield every case of a law."""
    for loop, from_observer in product(LOOPS, (False, True)):
        yield Case(loop, from_observer, defaults(law, loop))


def cases_at_ends(law: Law) -> Iterator[Case]:
    """Yield every case, each gain also at the ends of its range."""
    for case in cases(law):
        yield case
        for gain in law.gains:
            span = gain.span(case.loop)
            for value in [end for end in (span.low, span.high) if end != span.default]:
                gains = case.gains._replace(**{gain.name: value})
                yield case._replace(gains=gains, changed=f"{gain.name} = {value:g}")


def results_are_finite_records(law: Law) -> Iterator[ContractViolation]:
    """Prepare gives Constants, start Memory, step a number and Memory; all of it finite, at the start and just after."""
    for case in cases(law):
        constants = law.prepare(case.gains, H)
        yield from _checked("prepare", constants, law.Constants, case)
        memory = law.start(constants, Measured(0.3, -0.2), 0.1)
        yield from _checked("start", memory, law.Memory, case)
        arguments = (constants, case.channel(2.0), Setpoint(0.5, 0.1, 0.0), Measured(0.3, -0.2), STILL, H)
        result = law.step(memory, *arguments)
        if not (isinstance(result, tuple) and len(result) == 2):
            yield ContractViolation("step", f"gives {result!r}; it must give (command, Memory)")
            return
        if not (isinstance(result[0], float) and isfinite(result[0])):
            yield ContractViolation("step", f"commands {result[0]!r} {case.words}; it must be a finite number")
        yield from _checked("step", result[1], law.Memory, case)


def _checked(part: str, record: Any, kind: Any, case: Case) -> Iterator[ContractViolation]:
    if type(record) is not kind:
        yield ContractViolation(part, f"gives {type(record).__name__}; it must give {kind.__name__}")
    elif wrong := [f"{leaf!r}" for leaf in flatten(record) if not (isinstance(leaf, (int, float)) and isfinite(leaf))]:
        yield ContractViolation(part, f"gives {kind.__name__} with {wrong[0]} {case.words}; numbers must be finite")


def same_inputs_give_the_same(law: Law) -> Iterator[ContractViolation]:
    """Equal inputs give equal outputs, whatever was called between."""
    inputs = random_inputs(np.random.default_rng(5), 20)
    for case in cases(law):
        first, _ = run(law, case.gains, inputs, case.channel(2.0))
        run(law, case.gains, inputs[::-1], case.channel(3.0))
        repeated, _ = run(law, case.gains, inputs, case.channel(2.0))
        if not np.array_equal(first, repeated, equal_nan=True):
            yield ContractViolation(
                "step", "gives other commands for the same inputs: a state hides between calls; keep it in Memory"
            )
            return


# Terms of a command at rest cancel to rounding: each is at most a gain times the place, and a dozen operations leave 16 units in
# the last place of what the law commands against an error as large as that.
ROUNDED = 16.0 * float(np.finfo(float).eps)


def at_rest_nothing_changes(law: Law) -> Iterator[ContractViolation]:
    """At rest without an error nothing is commanded, and the memory stays what it is, wherever that is; rounding aside."""
    for case, place in product(cases_at_ends(law), (0.0, 1.7, -300.0)):
        constants, measured, channel = law.prepare(case.gains, H), Measured(place, 0.0), case.channel(2.0)
        memory = law.start(constants, measured, 0.0)
        command, after = law.step(memory, constants, channel, Setpoint(place, 0.0, 0.0), measured, STILL, H)
        if abs(command) > ROUNDED * _answer(law, constants, channel, measured):
            yield ContractViolation(
                "step", f"commands {command:g} at rest at {place:g} without an error, {case.words}; it must command 0"
            )
        elif not np.allclose(flatten(after), flatten(memory), rtol=ROUNDED, atol=ROUNDED * abs(place)):
            yield ContractViolation(
                "start", f"gives a memory that changes at rest at {place:g} without an error, {case.words}"
            )


def _answer(law: Law, constants: Any, channel: Channel, seen: Measured) -> float:
    """Return the size of a law's command after a jump from rest at 0."""
    command, _ = law.step(law.start(constants, Measured(0.0, 0.0), 0.0), constants, channel, REST, seen, STILL, H)
    return abs(command)


def commands_point_the_right_way(law: Law) -> Iterator[ContractViolation]:
    """Ahead where the setpoint is ahead, with the acceleration of the reference, and against a motion."""
    for case, sign in product(cases(law), (1.0, -1.0)):
        constants, channel = law.prepare(case.gains, H), case.channel(2.0)
        memory = law.start(constants, Measured(0.0, 0.0), 0.0)
        still = Measured(0.0, 0.0)
        ahead, _ = law.step(memory, constants, channel, Setpoint(0.1 * sign, 0.0, 0.0), still, STILL, H)
        pushed, _ = law.step(memory, constants, channel, Setpoint(0.0, 0.0, 0.1 * sign), still, STILL, H)
        if not ahead * sign > 0.0:
            yield ContractViolation("step", f"does not command towards the setpoint, {case.words}: its sign is wrong")
        # What does not follow an acceleration need not be pushed by it, what does not come to rest need not brake.
        if not pushed * sign > 0.0 and "tracks" in law.promises:
            yield ContractViolation(
                "step", f'does not follow setpoint.acceleration, {case.words}; add it, or do not promise "tracks"'
            )
        if not _braking(law, case, 0.1 * sign) * sign < 0.0 and "rejects" in law.promises:
            yield ContractViolation("step", f'does not brake a motion, {case.words}; or do not promise "rejects"')


def _braking(law: Law, case: Case, speed: float) -> float:
    """Return the command of a law after a second of consistent motion, without an error."""
    places = [speed * H * k for k in range(round(1.0 / H) + 1)]
    inputs = [Input(Setpoint(place, 0.0, 0.0), Measured(place, speed), STILL) for place in places]
    commands, _ = run(law, case.gains, inputs, case.channel(2.0))
    return float(commands[-1])


def only_the_error_counts(law: Law) -> Iterator[ContractViolation]:
    """Only the difference of reference and measurement counts.

    Moved by 64, values keep 6 bits less: 1e-14 each, amplified by gains up to l3 = 1e3 in the observer and by 1/h in a
    difference.
    """
    inputs = random_inputs(np.random.default_rng(1), 50)
    moved = [_moved(entry, 64.0) for entry in inputs]
    for case in cases(law):
        original, _ = run(law, case.gains, inputs, case.channel(2.0))
        shifted, _ = run(law, case.gains, moved, case.channel(2.0))
        if not np.ptp(original, axis=0) > 1.0:
            yield ContractViolation("step", f"hardly commands anything on inputs of order one, {case.words}")
        if not np.allclose(shifted, original, rtol=0.0, atol=1e-11 * np.abs(original).max(axis=0)):
            yield ContractViolation(
                "step", f"commands otherwise where reference and measurement are both moved by 64, {case.words}"
            )


def _moved(entry: Input, by: float) -> Input:
    return Input(
        entry.setpoint._replace(value=entry.setpoint.value + by),
        entry.measured._replace(value=entry.measured.value + by),
        entry.applied,
    )


def commands_scale_with_the_channel(law: Law) -> Iterator[ContractViolation]:
    """U b0 does not depend on b0 if what is delivered, in units of u, scales along; by a power of two to the last bit."""
    inputs = random_inputs(np.random.default_rng(2), 50)
    scaled = [i._replace(applied=Applied(i.applied.effect / 64.0, i.applied.excess / 64.0)) for i in inputs]
    for case in cases(law):
        small, _ = run(law, case.gains, inputs, case.channel(3.0))
        large, _ = run(law, case.gains, scaled, case.channel(192.0))
        if not np.array_equal(small, 64.0 * large):
            yield ContractViolation(
                "step", f"does not scale as 1/channel.b0, {case.words}: divide the acceleration asked for by channel.b0"
            )


def corners_stay_finite(law: Law) -> Iterator[ContractViolation]:
    """Commands and memory stay finite at the corners of the ranges."""
    inputs = random_inputs(np.random.default_rng(3), 20)
    for case in cases(law):
        for corner in _corners(law, case.loop):
            commands, memory = run(law, law.Gains(*corner), inputs, case.channel(300.0))
            if not (np.isfinite(commands).all() and np.isfinite(flatten(memory)).all()):
                at = ", ".join(f"{name} = {value:g}" for name, value in zip(law.Gains._fields, corner, strict=True))
                yield ContractViolation("step", f"does not stay finite at a corner of the ranges, {at}, {case.words}")
                return


def _corners(law: Law, loop: str) -> list[tuple[float, ...]]:
    """Return every corner of the ranges of a loop; of laws with many gains, some drawn."""
    ends = [(gain.span(loop).low, gain.span(loop).high) for gain in law.gains]
    if 2 ** len(ends) <= MAX_CORNERS:
        return list(product(*ends))
    high = np.random.default_rng(6).integers(2, size=(MAX_CORNERS, len(ends))).tolist()
    return [tuple(pair[k] for pair, k in zip(ends, row, strict=True)) for row in high]


def references_are_flown_as_promised(law: Law) -> Iterator[ContractViolation]:
    """Feedforward: the acceleration asked for is commanded and no more, filters of the law aside; or it is not promised.

    A held command flies piecewise constant acceleration exactly. Started a nanometre next to it, the error may not grow,
    and the command departs by no more than gains of 1e4 make of that.
    """
    offset = 1e-9
    plan = [1.0, -1.0, -0.5, 0.5]
    path = [Setpoint(0.2, 0.0, plan[0])]
    for k in range(400):
        y, v, a = path[-1]
        path.append(Setpoint(y + H * v + 0.5 * H * H * a, v + H * a, plan[(k + 1) // 101]))
    outcomes: list[tuple[str, bool]] = []
    for loop in LOOPS:
        gains = defaults(law, loop)
        gains = gains._replace(t_f=0.0) if "t_f" in gains._fields else gains
        flown = Axis(b0=4.0).fly(law, gains, 401, lambda t: path[round(t / H)], Measured(0.2 + offset, 0.0))
        away = np.abs(flown.value - [point.value for point in path]).max(axis=0)
        extra = np.abs(4.0 * flown.command - [point.acceleration for point in path]).max(axis=0)
        outcomes.append((loop, bool(away < 1.1 * offset and extra < 1e4 * offset)))
    yield from _promised(law, "tracks", outcomes, "a reference that can be flown")


# Slowest closed-loop pole with default gains: PID ki/kp = 1 and 0.24 1/s, the sliding surface 1 1/s: 120 s leave
# exp(-28) of 2 m.
def disturbances_are_rejected_as_promised(law: Law) -> Iterator[ContractViolation]:
    """A law that promises "rejects" leaves no error on a constant disturbance: 1e-9, at a constant command in the end."""
    outcomes: list[tuple[str, bool]] = []
    for case in cases(law):
        axis = Axis(b0=2.0, disturbance=0.7, from_observer=case.from_observer)
        flown = axis.fly(law, case.gains, 12000, lambda t: Setpoint(1.0, 0.0, 0.0), h=0.01)
        if not np.abs(flown.value - 1.0).max(axis=0) > 0.9:
            yield ContractViolation("step", f"is where it is asked to be before it moved, {case.words}")
        error = np.abs(flown.value[-100:] - 1.0).max(axis=0)
        unrest = np.abs(flown.command[-100:] + 0.7).max(axis=0)
        outcomes.append((case.loop, bool(error < 1e-9 and unrest < 1e-7)))
    yield from _promised(law, "rejects", outcomes, "a constant disturbance")


def _promised(law: Law, promise: str, outcomes: list[tuple[str, bool]], what: str) -> Iterator[ContractViolation]:
    """Yield the differences between a promise and the loops; a promise holds in every loop."""
    if promise not in law.promises:
        if all(each for _, each in outcomes):
            yield ContractViolation("promises", f'leaves no error on {what}; promise "{promise}"')
        return
    for loop in dict.fromkeys(loop for loop, each in outcomes if not each):
        yield ContractViolation(
            "step",
            f'leaves an error on {what} in the {loop} loop of y\'\' = b0 u, but promises "{promise}"; leave "{promise}" out of '
            "promises where it may: a law for first-order plants, such as PI, keeps neither there",
        )


def settling(value: Array) -> float:
    """Time [s] from which on a step to 1 stays within 2 %."""
    return H * float(np.nonzero(np.abs(value - 1.0) > 0.02)[0][-1] + 1)


def saturation_is_listened_to(law: Law) -> Iterator[ContractViolation]:
    """A saturated step overshoots little more than an unlimited one if the law gets the saturation input.

    The step needs ten times the limit. Without the input the law winds up; a law that promises "winds_up" does so with it too.
    """
    for loop in LOOPS:
        gains, duration = defaults(law, loop), 30.0
        unlimited = Axis().fly(law, gains, 250, _step).unlimited
        limit = 0.1 * float(np.abs(unlimited).max(axis=0))
        free, aware, unaware = (
            Axis(limit=bound, is_aware=is_aware).fly(law, gains, round(duration / H), _step)
            for bound, is_aware in ((np.inf, True), (limit, True), (limit, False))
        )
        if law.winds_up:
            if not np.array_equal(aware.value, unaware.value):
                yield ContractViolation(
                    "winds_up", f"is declared, but saturation changes the law in the {loop} loop; remove it"
                )
            continue
        if settling(free.value) == duration:
            if "rejects" in law.promises:
                yield ContractViolation("step", f"does not settle a step of 1 within {duration:g} s in the {loop} loop")
            continue
        # No command within the limit reaches 1 at rest sooner than full ahead for half the way and full astern for the rest.
        soonest = 2.0 * float(np.sqrt(1.0 / limit))
        if not settling(aware.value) < settling(free.value) + soonest:
            yield ContractViolation(
                "step",
                f"settles late after saturation in the {loop} loop: it winds up; use applied.excess or applied.effect",
            )
        # Braking is limited too: a law that asks for lambda^2 e to brake as it arrives overshoots where the limit is less.
        if not aware.value.max(axis=0) < free.value.max(axis=0) + 0.3:
            yield ContractViolation(
                "step",
                f"overshoots after saturation in the {loop} loop: it winds up; use applied.excess or applied.effect",
            )
        if "rejects" in law.promises and not unaware.value.max(axis=0) > aware.value.max(axis=0) + 0.15:
            yield ContractViolation("step", f"is equally good in the {loop} loop without the saturation input")


def _step(t: float) -> Setpoint:  # noqa: ARG001
    return Setpoint(1.0, 0.0, 0.0)


def amplitude_counts_only_as_told(law: Law) -> Iterator[ContractViolation]:
    """With a gain in place of each nonlinear function and no limits a law is linear to the bit; with its nonlinear functions,
    one that names any is not.
    """
    rng, large = np.random.default_rng(4), 2.0**20
    first, second = 1e-3 * rng.standard_normal((2, 60, 3))
    for case in cases(law):
        respond = _responder(law, case)
        alone = respond(first, True)
        if not np.abs(alone).min(axis=0) > 0.0:
            yield ContractViolation("step", f"commands nothing on small signals, {case.words}")
        together = respond(first + second, True)
        size = np.abs(together).max(axis=0)
        linear = np.array_equal(respond(large * first, True), large * alone)
        linear &= np.allclose(together, alone + respond(second, True), rtol=0.0, atol=1e-9 * size)
        if not linear:
            more = "more than what nonlinear names" if law.nonlinear else "an amplitude"
            yield ContractViolation(
                "step", f"depends on {more}, {case.words}; name the function through which it does in nonlinear"
            )
        elif np.array_equal(respond(large * first, False), large * respond(first, False)) != (not law.nonlinear):
            yield ContractViolation("nonlinear", "names a function on which nothing depends")


def _times(factor: float) -> Callable[..., Any]:
    """Return the function that multiplies its first argument."""

    def multiplied(signal: Any, *_: Any) -> Any:
        return factor * signal

    return multiplied


def _responder(law: Law, case: Case) -> Callable[[Array, bool], Array]:
    """Return the commands (K,) for y, rate and effect (K, 3) about rest, unsaturated; linear: with k s for each nonlinearity."""
    constants = law.prepare(case.gains, H)
    unlimited = {part: _times(1.0) for part in law.limits}
    stand_ins = {part.function: _times(float(k)) for k, part in enumerate(law.nonlinear, 2)}
    steps = {
        linear: Rebinder(PRIMITIVES, stand_ins={**unlimited, **(stand_ins if linear else {})})(law.step)
        for linear in (True, False)
    }

    def respond(inputs: Array, linear: bool) -> Array:
        memory = law.start(constants, Measured(0.0, 0.0), 0.0)
        commands: list[float] = []
        for value, rate, effect in inputs.tolist():
            seen, applied = Measured(value, rate), Applied(effect, 0.0)
            command, memory = steps[linear](memory, constants, case.channel(1.0), REST, seen, applied, H)
            commands.append(command)
        return np.array(commands)

    return respond


def nonlinearities_are_odd(law: Law) -> Iterator[ContractViolation]:
    """Each function through which a law depends on amplitude is odd, positive for a positive signal, and not linear."""
    for part, loop in product(law.nonlinear, LOOPS):
        if problem := _nonlinearity_problem(law, part, loop):
            yield ContractViolation("nonlinear", f"'{part.name}' {problem}, in the {loop} loop")


def limits_take_away_from_large_signals_alone(law: Law) -> Iterator[ContractViolation]:
    """Each limit is odd, passes what is small, and never makes a signal larger; a second signal next to it grows with it."""
    sizes = np.geomspace(1e-9, 1e6, 200)
    for part, loop in product(law.limits, LOOPS):
        constants = law.prepare(defaults(law, loop), H)
        passed, mirrored = (
            np.array([_passed(part, sign * s, constants) for s in sizes.tolist()]) for sign in (1.0, -1.0)
        )
        small = passed[:20] / sizes[:20]
        if not np.array_equal(mirrored, -passed) or not np.allclose(small, 1.0, rtol=0.0, atol=1e-6):
            yield ContractViolation(
                "limits", f"'{part.__name__}' is not odd with a slope of 1 at 0, in the {loop} loop"
            )
        elif not ((np.abs(passed) <= sizes).all() and (np.abs(passed) < 0.5 * sizes).any()):
            yield ContractViolation(
                "limits", f"'{part.__name__}' takes nothing away, or adds to a signal, in the {loop} loop"
            )


def _passed(part: Callable[..., Any], s: float, constants: Any) -> float:
    return part(*[s] * (len(signature(part).parameters) - 1), constants)


def _nonlinearity_problem(law: Law, part: Nonlinearity, loop: str) -> str:
    constants = law.prepare(defaults(law, loop), H)
    sizes = np.geomspace(1e-9, 1e3, 200)
    values = np.array([part.function(s, constants) for s in sizes.tolist()])
    mirrored = np.array([part.function(-s, constants) for s in sizes.tolist()])
    gains = values / sizes
    if not np.array_equal(mirrored, -values) or part.function(0.0, constants) != 0.0:
        return "is not odd"
    if not (values > 0.0).all():
        return "is not positive for a positive signal"
    if not np.ptp(gains, axis=0) > 0.1 * gains.max(axis=0):
        return "is linear"
    return (
        ""
        if part.unit.startswith("{y}") and "{" not in part.unit_in(loop)
        else "has a unit that does not begin with {y}"
    )


def the_continuous_observer_is_the_limit(law: Law) -> Iterator[ContractViolation]:
    """The declared observer of a law is its sampled one for a vanishing control period."""
    if law.observer is None:
        return
    omega_o, h = 10.0, 1e-6
    sampled = law.prepare(defaults(law, "attitude")._replace(omega_o=omega_o), h).observer
    if not np.allclose(np.array(sampled) / h, law.observer(omega_o), rtol=1e-4):
        yield ContractViolation("observer", "is not what prepare samples")
