"""Margins of plants of one's own against python-control, on loops put together from the user's derivative and the law alone.

A plant is sampled by python-control with its input held; a law is asked what each of its inputs does. Neither the
closing of the loop nor its linearisation has a part in it.
"""

from functools import cache

import numpy as np
import pytest

from objectives.margins.plant_margins import PlantMargins
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.model.plan import Actuator, Channel
from tests.objectives.margins.plant_parts import feedback, law_blocks, plant_blocks
from tests.objectives.margins.python_control import Loop, classical
from tests.plant.model.plants import pid, system_of

RELATIVE = 1e-6


def single_loop(system, gains):
    """Loop transfer function of a plant with one channel, broken where the command goes to the plant."""
    channel, actuator = system.plan.channels[0], system.plan.actuators[0]
    h = system.timing.control_period
    plant, law, wait = plant_blocks(system, actuator), law_blocks(channel, gains, h), actuator.periods(h)

    def loop(z):
        own = 1.0 - z ** -(wait + 1.0) * law["effect"](z)
        return -(z ** -float(wait)) * feedback(channel, law, plant, z) / own

    return loop


def cascade_loops(system, gains):
    """Loop transfer functions of a cascade without effects on its inner law: outer channel, inner channel."""
    outer, inner = system.plan.channels
    actuator, h = system.plan.actuators[0], system.timing.control_period
    split = len(outer.law.gains)
    plant, wait = plant_blocks(system, actuator), float(actuator.periods(h))
    above, below = law_blocks(outer, gains[:split], h), law_blocks(inner, gains[split:], h)

    def command(z):
        return feedback(outer, above, plant, z) / (1.0 - above["effect"](z) / z)

    def outer_loop(z):
        back = z**-wait * feedback(inner, below, plant, z)
        return -command(z) * z**-wait * below["goal"](z) / (1.0 - back)

    def inner_loop(z):
        return -(z**-wait) * (feedback(inner, below, plant, z) + below["goal"](z) * command(z))

    return outer_loop, inner_loop


def motor(law, gains, delay, lag):
    channel = Channel("angle", LAWS[law], "angle", "voltage", b0=2122.0, limit=10.0)
    actuator = Actuator("voltage", -12.0, 12.0, delay=delay, lag=lag)
    return system_of("dc_motor", [channel], [actuator], Timing(0.001, 0.0005)), np.array(gains)


def dead_time(periods, gains):
    actuator = Actuator("valve", delay=periods * 0.02)
    return system_of("dead_time", [pid("level", "level", "valve")], [actuator], Timing(0.02, 0.02)), np.array(gains)


def masses():
    channel = Channel("position", LAWS["ladrc"], "position", "force", b0=0.5)
    return system_of("two_masses", [channel], [], Timing(0.05, 0.025)), np.array([0.15, 1.0, 0.6])


def wing():
    channel = pid("pitch", "pitch", "elevator", b0=-18.0, rate_output="pitch_rate")
    actuator = Actuator("elevator", -0.35, 0.35, rate=5.0, delay=0.02, lag=0.05)
    return system_of("fixed_wing", [channel], [actuator], Timing(0.01, 0.005)), np.array([20.0, 20.0, 4.0, 0.01])


SINGLE = {
    "motor, PID": lambda: motor("pid", [900.0, 4000.0, 40.0, 0.002], 0.002, 0.002),
    "motor, ADRC": lambda: motor("ladrc", [20.0, 1.0, 60.0], 0.0, 0.001),
    "motor, paper's ADRC without a delay": lambda: motor("ladrc_printed", [15.0, 12.0, 50.0], 0.0, 0.0),
    "dead time of 5 periods": lambda: dead_time(5, [3.0, 3.0, 0.0, 0.02]),
    "dead time of 64 periods": lambda: dead_time(64, [0.4, 0.4, 0.1, 0.02]),
    "two masses": masses,
    "wing": wing,
    "dead time of 128 periods": lambda: dead_time(128, [0.3, 0.2, 0.1, 0.02]),
}


@cache
def judged(name):
    system, gains = SINGLE[name]() if name in SINGLE else cascade()
    model = PlantMargins(system, 0.9 * gains, 1.1 * gains)
    return system, gains, model, model.evaluate(gains[None])


def cascade():
    outer = Channel("angle", LAWS["ladrc"], "angle", "speed", b0=8.0)
    inner = pid("speed", "speed", "torque", b0=50.0)
    system = system_of("pendulum", [outer, inner], [Actuator("torque", delay=0.002, lag=0.004)], Timing(0.002, 0.001))
    return system, np.array([4.0, 1.0, 12.0, 60.0, 400.0, 0.1, 0.003])


def check(loop, model, margins, gains, name):
    h, i = model.control_period, model.channels.index(name)
    assert margins.stable[0, i]
    # From where an integral has brought T to 1 within 1e-9.
    w = np.geomspace(3e-5, np.pi / h, 600)
    judge = Loop(loop, h, w)
    closed = model.loop(gains, name, frequency=w).t
    np.testing.assert_allclose(closed, -judge.on_grid / (1.0 + judge.on_grid), rtol=1e-6, atol=1e-9)
    wanted = {
        **classical(judge),
        "sensitivity": 1.0 / judge.least(lambda x: np.abs(1.0 + x)),
        "complementary": 1.0 / judge.least(lambda x: np.abs(1.0 + 1.0 / x)),
    }
    found = {what: getattr(margins, what).value[0, i] for what in wanted}
    assert found == pytest.approx(wanted, rel=RELATIVE)


LONGEST = "dead time of 128 periods"


@pytest.mark.parametrize("name", [*SINGLE][:-1] + [pytest.param(LONGEST, marks=pytest.mark.slow)])
def test_margins_are_those_of_python_control(name):
    system, gains, model, margins = judged(name)
    check(single_loop(system, gains), model, margins, gains, system.plan.names[0])


def test_margins_of_a_cascade_are_those_of_python_control():
    system, gains, model, margins = judged("cascade")
    for channel, loop in zip(("angle", "speed"), cascade_loops(system, gains), strict=True):
        check(loop, model, margins, gains, channel)
