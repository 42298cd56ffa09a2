"""Margins of loops of several rates against loops lifted by hand and against the loop that is flown.

The loop is opened by hand at one channel: a recurrence of the plant's and the laws' matrices, instant by instant, whose answers to
unit states and unit signals, stacked, are the lifted loop. What is flown closes it with a factor on one command.
"""

from functools import cache
from typing import Any

import control
import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from objectives.margins.plant_margins import PlantMargins
from objectives.margins.plant_period import PlantPeriod
from objectives.margins.quantities import LOOP_QUANTITIES
from plant.backends.rebind import PRIMITIVES, Rebinder
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.model.closing import resting, to_plant
from plant.model.controller import to_channel
from plant.model.plan import Actuator, Channel
from plant.records import flatten, pack, size, zeros
from tests.objectives.margins.plant_parts import law_blocks, plant_blocks
from tests.objectives.margins.python_control import Loop, classical
from tests.plant.model.plants import pid, system_of

H = 0.004


def two_rates(every, late, outer="ladrc"):
    """A pendulum whose angle commands its speed at a slower rate."""
    channels = [
        Channel("angle", LAWS[outer], "angle", "speed", b0=8.0, every=every),
        pid("speed", "speed", "torque", b0=50.0),
    ]
    gains = {"ladrc": [3.0, 1.0, 9.0], "pid": [30.0, 20.0, 5.0, 0.01]}[outer]
    system = system_of("pendulum", channels, [Actuator("torque", delay=late * H, lag=0.004)], Timing(H, 0.002))
    return system, np.array([*gains, 40.0, 200.0, 0.1, 0.006])


def one_slow(every, late):
    """A pendulum held by one law that steps every few periods, its command a number of periods late that is no multiple."""
    channel = pid("angle", "angle", "torque", b0=50.0, every=every)
    system = system_of("pendulum", [channel], [Actuator("torque", delay=late * H)], Timing(H, 0.002))
    return system, np.array([80.0, 100.0, 14.0, 0.01])


CASES = {
    "every 4": lambda: two_rates(4, 1), "every 3, late": lambda: two_rates(3, 4), "PID over PID": lambda: two_rates(5, 0, "pid"),
    "one slow": lambda: one_slow(4, 0), "one slow, late": lambda: one_slow(4, 1),
}  # fmt: skip


@cache
def judged(name):
    system, gains = CASES[name]()
    model = PlantMargins(system, 0.9 * gains, 1.1 * gains)
    return system, gains, model, model.evaluate(gains[None])


class Opened:
    """The loop of a system opened at a channel, as matrices: plant, laws, held commands and queue, one instant after another."""

    def __init__(self, system, gains, broken):
        self.channels, self.broken, self.h = system.plan.channels, broken, system.timing.control_period
        (actuator,), self.laws = system.plan.actuators, []
        self.plant, self.late = plant_blocks(system, actuator), actuator.periods(self.h)
        for channel in self.channels:
            own, gains = gains[: len(channel.law.gains)], gains[len(channel.law.gains) :]
            self.laws.append(law_blocks(channel, own, channel.every * self.h))
        self.every = max(channel.every for channel in self.channels)
        one = self.plant[self.channels[0].output]
        self.sizes = [len(one.A), *[len(law["seen"].A) for law in self.laws], len(self.channels), self.late + 1]
        self.size = sum(self.sizes)

    def step(self, x, k, u):
        """State a period later and the command at the break, for a signal u in its place."""
        ends = np.cumsum([0, *self.sizes])
        parts = [x[low:high] for low, high in zip(ends[:-1], ends[1:], strict=True)]
        body, *memories, held, queue = [part.copy() for part in parts]
        seen, goal, command = {name: (each.C @ body)[0] for name, each in self.plant.items()}, 0.0, None
        for i, (channel, law) in enumerate(zip(self.channels, self.laws, strict=True)):
            inner = channel.to != "torque"
            if k % channel.every == 0:
                signals = {
                    "goal": goal,
                    "seen": seen[channel.output],
                    "effect": held[i] if inner else queue[0],
                    "rate": 0.0,
                }
                asked = law["seen"].C @ memories[i] + sum(law[what].D[0, 0] * v for what, v in signals.items())
                memories[i] = law["seen"].A @ memories[i] + sum(law[what].B[:, 0] * v for what, v in signals.items())
                held[i] = asked[0]
            goal = held[i]
            if channel.name == self.broken and inner:
                command, goal = held[i], u
        queue = np.append(queue[1:], held[-1])
        force = queue[0]
        if self.broken == self.channels[-1].name:
            command, force = force, u
        one = self.plant[self.channels[0].output]
        return np.concatenate([one.A @ body + one.B[:, 0] * force, *memories, held, queue]), command

    def lifted(self, every, first):
        """Matrices a, b, c, d over the common period, begun at control period `first`; signals held over `every` periods."""
        count = self.every // every
        rows = []
        for unit in np.eye(self.size + count):
            x, seen = unit[: self.size], []
            for k in range(self.every):
                x, command = self.step(x, first + k, unit[self.size + k // every])
                seen += [command] if k % every == 0 else []
            rows.append([*x, *seen])
        whole, n = np.array(rows).T, self.size
        return whole[:n, :n], whole[:n, n:], whole[n:, :n], whole[n:, n:]


def radius(matrices, factor):
    """Spectral radius of a lifted loop closed with a factor on all its commands."""
    a, b, c, d = matrices
    return np.abs(np.linalg.eigvals(a + factor * b @ np.linalg.solve(np.eye(len(d)) - factor * d, c))).max()


SLOW = [
    ("every 4", "angle"),
    ("every 3, late", "angle"),
    ("PID over PID", "angle"),
    ("one slow", "angle"),
    ("one slow, late", "angle"),
]


@pytest.mark.parametrize(("name", "channel"), SLOW)
def test_a_slow_channel_has_the_margins_of_the_loop_sampled_at_its_period(name, channel):
    system, gains, model, margins = judged(name)
    opened, i = Opened(system, gains, channel), model.channels.index(channel)
    assert margins.stable[0, i]
    first = opened.late % opened.every if name.startswith("one") else 0
    period = opened.every * H
    sampled = control.ss(*opened.lifted(opened.every, first), period)
    judge = Loop(lambda z: -sampled(z), period, np.geomspace(1e-3, np.pi / period, 800))
    wanted = {
        **classical(judge),
        "sensitivity": 1.0 / judge.least(lambda x: np.abs(1.0 + x)),
        "complementary": 1.0 / judge.least(lambda x: np.abs(1.0 + 1.0 / x)),
    }
    assert {what: getattr(margins, what).value[0, i] for what in wanted} == pytest.approx(wanted, rel=1e-6)
    growth = np.log(radius(opened.lifted(opened.every, first), 1.0)) / period
    assert margins.growth[0, i] == pytest.approx(growth, rel=1e-6)


FAST = ["every 4", "every 3, late", "PID over PID"]


@pytest.mark.parametrize("name", FAST)
def test_a_fast_channel_keeps_stable_up_to_its_margins(name):
    system, gains, model, margins = judged(name)
    matrices, i = Opened(system, gains, "speed").lifted(1, 0), model.channels.index("speed")
    up, down, phase = (getattr(margins, what).value[0, i] for what in ("gain_up", "gain_down", "phase"))
    assert 1.0 < up < 1e4
    assert brentq(lambda k: radius(matrices, k) - 1.0, 0.9 * up, 1.1 * up) == pytest.approx(up, rel=1e-6)
    for factor in np.geomspace(1.0, 0.999 * up, 40):
        assert radius(matrices, factor) < 1.0
    lowest = 1e-3 if np.isinf(down) else 1.001 / down
    assert max(radius(matrices, factor) for factor in np.geomspace(lowest, 1.0, 40)) < 1.0
    turned = brentq(lambda angle: radius(matrices, np.exp(-1j * angle)) - 1.0, 0.9 * phase, 1.1 * phase)
    assert turned == pytest.approx(phase, rel=1e-6)
    assert max(radius(matrices, np.exp(1j * angle)) for angle in np.linspace(-0.999 * phase, 0.999 * phase, 40)) < 1.0


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name == "PID over PID" else pytest.mark.slow) for name in FAST]
)
def test_the_peaks_of_a_fast_channel_are_norms_of_the_lifted_loop(name):
    system, gains, model, margins = judged(name)
    a, b, c, d = Opened(system, gains, "speed").lifted(1, 0)
    i, unit = model.channels.index("speed"), np.eye(len(d))
    closed, period = a + b @ np.linalg.solve(unit - d, c), len(d) * H
    system_t = control.ss(
        closed, b @ np.linalg.inv(unit - d), np.linalg.solve(unit - d, c), np.linalg.inv(unit - d) - unit, period
    )

    def height(w, level):
        return np.linalg.norm(np.atleast_2d(system_t(np.exp(1j * w * period))) + level * unit, 2)

    grid = np.concatenate([np.geomspace(1e-3, np.pi / period, 500), np.linspace(0.0, np.pi / period, 500)])
    grid.sort()
    for what, level in (("sensitivity", 1.0), ("complementary", 0.0)):
        best = int(np.argmax([height(w, level) for w in grid]))
        ends = grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)]
        found: Any = minimize_scalar(
            lambda w, level=level: -height(w, level), bounds=ends, method="bounded", options={"xatol": 1e-9}
        )
        assert getattr(margins, what).value[0, i] == pytest.approx(max(-found.fun, height(grid[best], level)), rel=1e-6)


@pytest.mark.parametrize("name", FAST)
def test_a_queue_shorter_than_the_delay_margin_leaves_the_loop_stable(name):
    """A delay of a whole number of control periods is a longer queue of the input, of which the laws know nothing."""
    system, gains, model, margins = judged(name)
    matrices = Opened(system, gains, "speed").lifted(1, 0)
    steps = margins.delay.value[0, model.channels.index("speed")] / H
    assert steps > 1.0
    stable = [delayed_radius(matrices, periods) < 1.0 for periods in range(int(steps) + 2)]
    assert stable == [True] * (int(steps) + 1) + [False]


def delayed_radius(matrices, periods):
    """Spectral radius of a lifted loop whose commands come into force some steps late."""
    a, b, c, d = matrices
    n, q = len(a), len(d)
    columns = []
    for unit in np.eye(n + periods):
        x, queue = unit[:n], list(unit[n:])
        for i in range(q):
            queue.append(c[i] @ x + d[i, :i] @ np.array(queue[:i]))
        columns.append([*(a @ x + b @ np.array(queue[:q])), *queue[q:]])
    return np.abs(np.linalg.eigvals(np.array(columns).T)).max()


EVERY = [entry.field for entry in LOOP_QUANTITIES]


def test_a_fast_channel_under_a_slow_one_of_hardly_any_gain_has_the_margins_of_one_rate():
    inner, motor = pid("speed", "speed", "torque", b0=50.0), Actuator("torque", delay=H, lag=0.004)
    outer = [pid("angle", "angle", "speed", every=every) for every in (4, 1)]
    gains = np.array([1e-4, 0.0, 0.0, 0.01, 60.0, 200.0, 0.5, 0.006])
    lifted, plain = (
        PlantMargins(system_of("pendulum", [each, inner], [motor], Timing(H, 0.002)), gains, gains).evaluate(
            gains[None]
        )
        for each in outer
    )
    assert np.isfinite(plain.sensitivity.value[0, 1]) and plain.rejection.value[0, 1] > 50.0
    for what in EVERY:
        found, wanted = (getattr(margins, what) for margins in (lifted, plain))
        assert found.value[0, 1] == pytest.approx(wanted.value[0, 1], rel=2e-6), what
        if what not in ("load_index", "gain_down"):
            assert found.frequency[0, 1] == pytest.approx(wanted.frequency[0, 1], rel=1e-4), what


def test_a_channel_at_every_other_period_has_the_margins_of_a_period_twice_as_long():
    """The same law at the same instants."""
    slow, gains = one_slow(2, 0)
    plain = system_of("pendulum", [pid("angle", "angle", "torque", b0=50.0)], [], Timing(2.0 * H, 0.002))
    here, there = (PlantMargins(each, 0.9 * gains, 1.1 * gains).evaluate(gains[None]) for each in (slow, plain))
    for what in EVERY:
        assert getattr(here, what).value == pytest.approx(getattr(there, what).value, rel=1e-6), what


@pytest.mark.slow
@pytest.mark.parametrize("name", ["every 4", "every 3, late"])
@pytest.mark.parametrize("channel", ["angle", "speed"])
def test_what_is_flown_rests_below_the_gain_margin_and_swings_up_above(name, channel):
    system, gains, model, margins = judged(name)
    up = margins.gain_up.value[0, model.channels.index(channel)]
    assert grown(system, gains, channel, 0.97 * up) < 1.0 < grown(system, gains, channel, 1.03 * up)


def grown(system, gains, channel, factor, periods=3000):
    """How far the later of the flown loop's swings about rest exceed the earlier, with a factor on a channel's command."""
    number = system.plan.number(channel)
    function = to_channel if channel == "angle" else to_plant
    loop = PlantPeriod(system).loop
    held = np.array(flatten(resting(loop, system.parameters)[1].actuators))[0]
    level = 0.0 if function is to_channel else held

    def stronger(command, at):
        return level + factor * (command - level) if at == number else command

    bound = Rebinder(PRIMITIVES, stand_ins={function: stronger})
    decide, advance = bound(loop.decide), loop.advance
    dynamics, body = resting(loop, system.parameters)
    kinds = loop.records
    constants = loop.prepare(pack(kinds.Gains, gains.tolist()), H)
    reference = kinds.Reference(*[type(part)(0.0, 0.0, 0.0) for part in zeros(kinds.Reference)])
    shown = body.shown
    reference = reference._replace(
        **{
            each.name: getattr(reference, each.name)._replace(value=getattr(shown, each.output))
            for each in system.plan.channels
        }
    )
    still = [zeros(kind) for kind in (kinds.Noise, kinds.Targets, kinds.Dynamics)]
    flight = loop.start(body, constants, system.nominal, reference, *still)
    pushed = flight.body._replace(state=flight.body.state._replace(speed=1e-7))
    flight, sizes = flight._replace(body=pushed), []
    limits = pack(kinds.Limits, [1e9] * size(kinds.Limits))
    for k in range(periods):
        flight = decide(
            flight, constants, system.nominal, reference, zeros(kinds.Noise), zeros(kinds.Targets), limits, k * H, H
        )
        for _ in range(system.timing.steps):
            flight = flight._replace(body=advance(flight.body, flight.speed, zeros(kinds.Disturbance), dynamics, 0.002))
        sizes.append(abs(flight.body.state.speed))
    third = periods // 3
    return max(sizes[2 * third :]) / max(sizes[third : 2 * third])
