"""Flights of plants of one's own: Python, compiled lanes and an integrator that knows nothing of our closing say the same."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from objectives.plant_system import PlantSystem
from plant.backends.flyer import Flyer
from plant.backends.stepping import fly_steps, lane_of, unchanged
from plant.laws.channel import Applied, Measured, Setpoint
from plant.laws.channel import Channel as Known
from plant.loop import Timing
from plant.model.plan import plan_loop
from plant.model.scenario import PlantScenario, SensorNoise
from plant.model.signals import Coloured, Sine, Step
from plant.records import flatten, pack, paths, rows
from tests.plant.model.plants import CASCADE_GAINS, FILES, cascade, pid, read, stepped

SPEC = PlantScenario(
    "swing", 0.8, {"angle": Step(0.8, 0.05)}, {"push": Coloured(0.05, 0.02)},
    {"angle": SensorNoise(1e-3, 2e-3), "speed": SensorNoise(1e-2)}, {"inertia": 0.2, "weight": 0.3},
)  # fmt: skip
FLIGHTS = 20


@cache
def drawn():
    return cascade().sample(SPEC, 7, "search", range(FLIGHTS))


@cache
def results(threads):
    system = cascade()
    gains = np.array([CASCADE_GAINS, 0.9 * CASCADE_GAINS, 1.1 * CASCADE_GAINS])
    return Flyer(system.loop, system.limits, system.timing, threads).fly(gains, system.nominal, drawn())


def parameters_of(system, lane):
    size = len(flatten(system.parameters))
    return pack(system.plant.Parameters, drawn().dynamics[0, :size, lane].tolist())


class Independent:
    """The cascade of the pendulum, flown by solve_ivp from one control instant to the next; the laws are asked step by step."""

    def __init__(self, system, lane):
        self.system, self.lane = system, lane
        self.p = parameters_of(system, lane)
        self.h = system.timing.control_period
        angle, speed = system.plan.channels
        gains = {"angle": angle.law.Gains(*CASCADE_GAINS[:3]), "speed": speed.law.Gains(*CASCADE_GAINS[3:])}
        self.constants = {
            "angle": angle.law.prepare(gains["angle"], 4 * self.h),
            "speed": speed.law.prepare(gains["speed"], self.h),
        }
        self.laws = {"angle": angle, "speed": speed}

    def step(self, name, memory, goal, seen, effect, excess, h):
        channel = self.laws[name]
        return channel.law.step(
            memory,
            self.constants[name],
            Known(channel.b0, 1.0),
            Setpoint(goal, 0.0, 0.0),
            Measured(seen, 0.0),
            Applied(effect, excess),
            h,
        )

    def fly(self, steps):
        state, held = self.system.plant.rest(self.p)
        torque = held.torque
        x = np.array([*state, torque])
        noise, push = drawn().noises[0, :, :, self.lane], drawn().disturbances[0, :, 0, self.lane]
        goals = drawn().references[:, 0]
        seen = np.array(state) + noise[0]
        memory = {
            "angle": self.laws["angle"].law.start(self.constants["angle"], Measured(seen[0], 0.0), 8.0 * seen[1]),
            "speed": self.laws["speed"].law.start(self.constants["speed"], Measured(seen[1], 0.0), 50.0 * torque),
        }
        wanted_speed, outer_excess, inner_excess = seen[1], 0.0, 0.0
        asked, queue, in_force, bodies = torque, [torque] * 3, torque, []
        for k in range(steps):
            bodies.append([x[0], x[1], x[2], x[0], x[1]])
            seen = x[:2] + noise[k]
            if k % 4 == 0:
                demand, memory["angle"] = self.step(
                    "angle", memory["angle"], goals[k], seen[0], wanted_speed, outer_excess, 4 * self.h
                )
                wanted_speed = min(max(demand, -3.0), 2.5)
                outer_excess = wanted_speed - demand
            demand, memory["speed"] = self.step(
                "speed", memory["speed"], wanted_speed, seen[1], in_force, inner_excess, self.h
            )
            slewed = min(max(demand, asked - 12.0 * self.h), asked + 12.0 * self.h)
            asked = min(max(slewed, -0.6), 0.9)
            inner_excess = asked - demand
            queue.append(asked)
            in_force = queue.pop(0)
            x = self.move(x, in_force, push[k])
        return np.array(bodies)

    def move(self, x, force, push):
        plant = self.system.plant

        def rate(_, x):
            there = plant.derivative(plant.State(*x[:2]), plant.Input(x[2]), plant.Disturbance(push), self.p)
            return [*there, (force - x[2]) / 0.004]

        return solve_ivp(rate, (0.0, self.h), x, rtol=1e-11, atol=1e-12).y[:, -1]


def test_the_cascade_meets_its_limits():
    """The flights below would prove little if nothing were clipped, slewed or failed to wait."""
    bodies, flight = stepped(cascade(), CASCADE_GAINS, drawn())
    assert flight.status == 0.0
    assert flight.meters.saturated > 0.01
    assert np.ptp(bodies[:, 0], axis=0) > 0.5


@pytest.mark.parametrize("lane", [0, 3])
def test_flights_are_those_of_an_independent_integrator(lane):
    steps = len(drawn().references)
    wanted = Independent(cascade(), lane).fly(steps)
    bodies, _ = stepped(cascade(), CASCADE_GAINS, drawn(), lane)
    scale = np.abs(wanted).max(axis=0)
    errors = np.abs(bodies - wanted) / scale
    assert errors.max() < 1e-4
    fine = cascade()
    object.__setattr__(fine, "timing", Timing(0.002, 0.00025))
    closer = np.abs(stepped(fine, CASCADE_GAINS, drawn(), lane)[0] - wanted) / scale
    # Fourth order: steps of a quarter leave 1/256 of the error, or what the integrator leaves.
    assert closer.max() < max(errors.max() / 100.0, 1e-9)


@pytest.mark.parametrize("lane", [0, 3, 15])
def test_lanes_fly_what_python_steps(lane):
    system = cascade()
    flyer = Flyer(system.loop, system.limits, system.timing, 1)
    body = rows(system.loop.Flight, "body")
    trace = flyer.trace(CASCADE_GAINS, system.nominal, drawn(), traced=range(body.start, body.stop))
    bodies, flight = stepped(system, CASCADE_GAINS, drawn(), lane)
    np.testing.assert_allclose(trace[lane], bodies, rtol=1e-9, atol=1e-11)
    last = [*flatten(flight.meters), flight.status, flight.end_time]
    np.testing.assert_allclose(results(1)[0, lane], last, rtol=1e-9, atol=1e-11)


def test_bits_do_not_depend_on_threads():
    assert np.array_equal(results(1), results(3))


def test_bits_do_not_depend_on_lane_or_batch():
    system = cascade()
    flyer = Flyer(system.loop, system.limits, system.timing, 1)
    chosen = [17, 3, 9]
    others = system.sample(SPEC, 7, "search", chosen)
    alone = flyer.fly(1.1 * CASCADE_GAINS[None], system.nominal, others)
    assert np.array_equal(alone[0], results(1)[2, chosen])


def test_flights_start_where_the_drawn_plant_rests():
    """Without a disturbance and with the reference where it hangs, it stays there, whatever its weight."""
    system = cascade()
    spec = PlantScenario("still", 0.2, spread={"weight": 0.5, "inertia": 0.5})
    still = system.sample(spec, 1, "search", range(16))
    traced = range(*rows(system.loop.Flight, "body").indices(1000))
    trace = Flyer(system.loop, system.limits, system.timing, 1).trace(
        CASCADE_GAINS, system.nominal, still, traced=traced
    )
    assert np.ptp(still.dynamics[0, paths(system.loop.records.Dynamics).index("parameters.weight")], axis=0) > 0.1
    np.testing.assert_allclose(trace, trace[:, :1].repeat(trace.shape[1], axis=1), atol=1e-9)


def test_a_flight_beyond_its_limit_ends_there():
    system = cascade()
    spec = PlantScenario("far", 0.4, {"angle": Sine(6.0, 1.0)})
    inputs = system.sample(spec, 1, "search", [0])
    flown = Flyer(system.loop, system.limits, system.timing, 1).fly(CASCADE_GAINS[None], system.nominal, inputs)[0, 0]
    bodies, flight = stepped(system, CASCADE_GAINS, inputs)
    missed = np.abs(inputs.references[:, 0] - bodies[:, 0]) >= 4.0
    assert flown[-2] == flight.status == 2.0
    assert flown[-1] == pytest.approx(np.argmax(missed) * 0.002, abs=1e-12)


def test_feedthrough_shows_the_input_of_the_period_before(tmp_path):
    """An output that shows its input closes no loop without a state: it shows what moved the plant until now."""
    text = (
        FILES["dc_motor"]
        .read_text(encoding="utf-8")
        .replace("Output(state.angle)", "Output(state.angle + input.voltage)")
    )
    (tmp_path / "motor.py").write_text(text, encoding="utf-8")
    plant = read(tmp_path / "motor.py")
    plan = plan_loop(plant, [pid("angle", "angle", "voltage")])
    system = PlantSystem(plant, plan, plant.parameters, Timing(0.001, 0.001))
    drawn = system.sample(PlantScenario("step", 0.05, {"angle": Step(1.0)}), 1, "search", [0])
    seen = []
    fly_steps(
        system.loop,
        unchanged,
        pack(system.loop.records.Gains, [0.2, 0.0, 0.0, 0.001]),
        system.nominal,
        lane_of(drawn, 0),
        drawn.targets,
        system.limits,
        system.timing,
        lambda k, flight: seen.append(flight),
    )
    fed = [after.body.shown.angle - after.body.state.angle for after in seen[1:]]
    assert fed == pytest.approx([before.speed.voltage for before in seen[:-1]], rel=1e-12)
    assert np.ptp(fed) > 0.05


@pytest.mark.parametrize(("name", "below"), [("speed", "inner"), ("x", "torque"), ("speed", "torque")])
def test_a_channel_may_have_any_name(name, below):
    """Channels that are called as their input or as an output fly as under any other name."""
    system = cascade()
    outer, inner = system.plan.channels
    outer, inner = replace(outer, name=name, to=below), replace(inner, name=below)
    renamed = replace(system, plan=plan_loop(system.plant, [outer, inner], system.plan.actuators))
    spec = replace(SPEC, references={name: SPEC.references["angle"]})
    inputs = renamed.sample(spec, 7, "search", range(3))
    flown = stepped(renamed, CASCADE_GAINS, inputs)[0]
    assert np.array_equal(flown, stepped(system, CASCADE_GAINS, drawn())[0])
