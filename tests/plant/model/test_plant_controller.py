"""The controller of a plant by itself: rates of channels, limits, slew, delays, and a start at rest; seen in flights of its loop."""

from typing import Annotated, NamedTuple

import numpy as np
import pytest

from objectives.plant_system import PlantSystem
from plant.backends.stepping import fly_steps, lane_of, unchanged
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.model.plan import Actuator, Channel, plan_loop
from plant.model.plant_model import plant_from
from plant.model.scenario import PlantScenario, SensorNoise
from plant.model.signals import Constant, Step
from plant.own_code import run_own_code
from plant.primitives import cos
from plant.records import pack
from tests.plant.own_files import LAW

PERIOD = 0.01


class State(NamedTuple):
    angle: Annotated[float, "rad"]
    rate: Annotated[float, "rad/s"]


class Input(NamedTuple):
    torque: Annotated[float, "N m"]


class Parameters(NamedTuple):
    weight: Annotated[float, "N m"] = 4.0


class Output(NamedTuple):
    angle: Annotated[float, "rad"]
    rate: Annotated[float, "rad/s"]


def derivative(state, input, disturbance, parameters):
    return State(state.rate, input.torque - parameters.weight * cos(state.angle))


def output(state, input, disturbance, parameters):
    return Output(state.angle, state.rate)


def rest(parameters):
    return State(0.0, 0.0), Input(parameters.weight)


ARM = plant_from(globals(), "arm")
GAINS = [20.0, 10.0, 9.0, 0.02]


def flown(channels, actuators=(), gains=GAINS, goal=None, noise=0.0):
    """Memory of the controller of an arm at every control instant of a second."""
    system = PlantSystem(ARM, plan_loop(ARM, channels, actuators), ARM.parameters, Timing(PERIOD, PERIOD))
    goals = {each.name: goal or Step(0.5, 0.1) for each in system.plan.outer}
    spec = PlantScenario("second", 1.0, goals, {}, {"angle": SensorNoise(noise), "rate": SensorNoise(noise)})
    drawn = system.sample(spec, 1, "controller", [0])
    row = pack(system.loop.records.Gains, gains * len(channels))
    kept = []
    fly_steps(
        system.loop,
        unchanged,
        row,
        system.nominal,
        lane_of(drawn, 0),
        drawn.targets,
        system.limits,
        system.timing,
        lambda _, flight: kept.append(flight.control),
    )
    return kept


def single(**options):
    return [Channel("angle", LAWS["pid"], "angle", "torque", **options)]


def test_a_flight_starts_at_rest_under_the_input_that_holds_it():
    for options in ({}, {"rate_output": "rate"}):
        torques = [kept.command.torque for kept in flown(single(**options), goal=Constant(0.0))]
        assert torques == pytest.approx([4.0] * 100, abs=1e-12)


def test_a_slower_channel_steps_every_so_many_periods():
    cascade = [
        Channel("angle", LAWS["pid"], "angle", "turning", every=5),
        Channel("turning", LAWS["pid"], "rate", "torque"),
    ]
    kept = flown(cascade, gains=[2.0, 0.0, 0.1, 0.02], noise=1e-3)
    outer = np.array([each.commands.angle for each in kept])
    memory = np.array([each.laws.angle.previous for each in kept])
    inner = np.array([each.commands.turning for each in kept])
    for held in (outer, memory):
        assert np.array_equal(np.flatnonzero(np.diff(held)) + 1, np.arange(5, 100, 5))
    assert np.count_nonzero(np.diff(inner)) == 99


@pytest.mark.parametrize("every", [1, 4])
def test_a_law_is_given_the_difference_of_what_it_sees_where_nothing_measures_the_rate(every):
    """The shipped law takes the rate as it is given it: PID without a filter, whose bundled form differences by itself."""
    plain = Channel("angle", run_own_code(LAW).names["LAW"], "angle", "torque", every=every)
    given, own = (
        flown([channel], gains=gains, noise=1e-3)
        for channel, gains in ((plain, [20.0, 10.0, 9.0]), (*single(every=every), [20.0, 10.0, 9.0, 0.0]))
    )
    commands = [np.array([each.command.torque for each in kept]) for kept in (given, own)]
    assert commands[0] == pytest.approx(commands[1], rel=1e-9)
    assert np.ptp(commands[0], axis=0) > 10.0


def test_a_flight_begins_without_a_rate():
    """What is seen first is all noise: nothing may be made of its difference from 0."""
    law = run_own_code(LAW).names["LAW"]
    first = flown([Channel("angle", law, "angle", "torque")], gains=[1e-9, 0.0, 9.0], goal=Constant(0.0), noise=1e-2)[0]
    assert first.command.torque == pytest.approx(4.0, abs=1e-9)


@pytest.mark.parametrize("periods", [0, 1, 3])
def test_a_command_comes_into_force_after_its_delay(periods):
    kept = flown(single(), [Actuator("torque", delay=periods * PERIOD)])
    sent, in_force = ([getattr(each, part).torque for each in kept] for part in ("command", "in_force"))
    assert in_force[periods:] == sent[: 100 - periods]
    assert in_force[:periods] == [4.0] * periods


def test_a_command_keeps_to_its_rate_and_its_limits():
    kept = flown(single(), [Actuator("torque", low=3.0, high=6.0, rate=20.0)])
    sent = np.array([each.command.torque for each in kept])
    steps = np.abs(np.diff(sent))
    assert steps.max(axis=0) == pytest.approx(20.0 * PERIOD, rel=1e-9)
    assert (sent.min(axis=0), sent.max(axis=0)) == (3.0, 6.0)
    for each, command in zip(kept, sent, strict=True):
        assert each.shortfall.torque == pytest.approx(command - each.commands.angle, abs=1e-12)


def test_a_channel_may_bear_the_name_of_its_input():
    channels = [Channel("torque", LAWS["pid"], "angle", "torque", high=8.0)]
    kept = flown(channels, [Actuator("torque", high=6.0)])
    assert max(each.commands.torque for each in kept) == 8.0
    assert max(each.command.torque for each in kept) == 6.0


def test_channels_of_one_input_share_what_holds_it():
    channels = [*single(), Channel("turning", LAWS["pid"], "rate", "torque")]
    first = flown(channels, goal=Constant(0.0))[0]
    assert first.commands == pytest.approx((2.0, 2.0), abs=1e-12)
    assert first.command.torque == pytest.approx(4.0, abs=1e-12)
