"""Designs of channels of plants of one's own: python-control's peaks of what is found, and what is best among its neighbours."""

from math import inf

import numpy as np
import pytest

from objectives.design import DesignRequirements
from objectives.design.plant_design import ChannelTask, design_channels, loop_parts
from objectives.margins.plant_margins import PlantMargins
from plant.loop import Timing
from plant.model.plan import Actuator
from tests.objectives.margins.test_plant_margin_control import single_loop
from tests.plant.model.plants import CASCADE_GAINS, cascade, pid, system_of

REQUIREMENTS = DesignRequirements()


def motor():
    actuator = Actuator("voltage", delay=0.001, lag=0.001)
    return system_of("dc_motor", [pid("angle", "angle", "voltage")], [actuator], Timing(0.001, 0.0005))


def process():
    return system_of("dead_time", [pid("level", "level", "valve")], [Actuator("valve", delay=0.4)], Timing(0.02, 0.02))


CASES = {
    "motor": (motor, np.array([10.0, 10.0, 0.2, 0.001]), [1e-2, 1e-2, 1e-4, 0.001], [1e3, 1e5, 1e2, 0.001]),
    "process": (process, np.array([0.5, 0.4, 0.1, 0.05]), [1e-3, 1e-3, 1e-4, 0.05], [1e3, 1e3, 1e2, 0.05]),
    "process without derivative": (process, np.array([0.5, 0.4, 0.0, 0.05]), [1e-3, 1e-3, 0.0, 0.05], [1e3, 1e3, 0.0, 0.05]),
}  # fmt: skip


def peaks(system, gains):
    """Largest |S| and |T| of the loop put together by python-control."""
    loop, h = single_loop(system, gains), system.timing.control_period
    value = loop(np.exp(1j * np.geomspace(1e-3, np.pi / h, 4000) * h))
    return np.abs(1.0 / (1.0 + value)).max(axis=0), np.abs(value / (1.0 + value)).max(axis=0)


def task(system, name, low, high, noise=(0.0, 0.0), authority=inf, step=0.0):
    return ChannelTask(system.plan.channel(name), np.array(low), np.array(high), noise, step, authority)


@pytest.mark.parametrize("name", CASES)
def test_a_design_is_stable_keeps_its_peaks_and_stands_at_a_limit(name):
    build, start, low, high = CASES[name]
    system = build()
    channel = system.plan.names[0]
    row, found = design_channels(system, start, {channel: task(system, channel, low, high)}, REQUIREMENTS)
    assert found[channel].designed, found[channel].why
    ms, mt = peaks(system, row)
    assert (ms, mt) == pytest.approx((found[channel].ms, found[channel].mt), rel=1e-3)
    assert ms <= REQUIREMENTS.ms and mt <= REQUIREMENTS.mt
    assert max(ms / REQUIREMENTS.ms, mt / REQUIREMENTS.mt) > 0.98
    assert PlantMargins(system, row, row).evaluate(row[None]).stable[0, 0]
    # More of both kp and ki breaks a limit.
    more = row * np.array([1.05, 1.05, 1.0, 1.0])
    assert max(peaks(system, more)[0] / REQUIREMENTS.ms, peaks(system, more)[1] / REQUIREMENTS.mt) > 1.01


def test_the_parts_make_the_loop_that_flies():
    system, gains = motor(), np.array([7.0, 40.0, 0.06, 0.001])
    w = np.geomspace(1.0, 3000.0, 30)
    loop = loop_parts(system, gains, system.plan.channels[0], w) @ gains[:3]
    np.testing.assert_allclose(loop, single_loop(system, gains)(np.exp(1j * w * 0.001)), rtol=1e-6)


def test_noise_and_steps_bound_what_is_asked_of_the_input():
    system, (_, start, low, high) = motor(), CASES["motor"]
    (free, _), (quiet, _), (stepped, _) = (
        design_channels(system, start, {"angle": task(system, "angle", low, high, **given)}, REQUIREMENTS)
        for given in ({}, {"noise": (0.02, 0.0), "authority": 6.0}, {"step": 2.0, "authority": 6.0})
    )
    assert quiet[0] * 0.02 <= 0.02 * 6.0 * 1.001 < free[0] * 0.02
    assert stepped[0] <= 3.0 * (1.0 + 1e-6) < free[0]


def test_the_inner_channel_comes_first_and_the_outer_one_acts_through_it():
    timing, names = Timing(0.002, 0.001), ("angle", "speed")
    channels = [pid("angle", "angle", "speed"), pid("speed", "speed", "torque")]
    system = system_of("pendulum", channels, [Actuator("torque", lag=0.004)], timing)
    start = np.array([1.0, 0.1, 0.001, 0.01, 0.2, 0.2, 0.0001, 0.01])
    low, high = 1e-3 * start, 1e3 * start
    low[[3, 7]] = high[[3, 7]] = 0.01
    tasks = {name: task(system, name, low, high) for name in names}
    row, found = design_channels(system, start, tasks, REQUIREMENTS)
    assert all(found[name].designed for name in names)
    margins = PlantMargins(system, row, row).evaluate(row[None])
    assert margins.stable.all() and (margins.sensitivity.value[0, 0] <= REQUIREMENTS.ms)


def test_what_cannot_be_designed_keeps_its_gains_and_says_why():
    system = cascade()
    tasks = {name: task(system, name, CASCADE_GAINS, CASCADE_GAINS) for name in system.plan.names}
    row, found = design_channels(system, CASCADE_GAINS, tasks, REQUIREMENTS)
    np.testing.assert_array_equal(row, CASCADE_GAINS)
    assert "no designer for the law 'ladrc'" in found["angle"].why and "several rates" in found["speed"].why
    single, (_, start, *_) = motor(), CASES["motor"]
    fixed, kept = design_channels(
        single, start, {"angle": task(single, "angle", 1e3 * start, 1e3 * start)}, REQUIREMENTS
    )
    assert not kept["angle"].designed and "no loop is stable" in kept["angle"].why
    np.testing.assert_array_equal(fixed, start)
