"""Margins of rotors with dead time, against the closed form: the loop of the rotors without it, turned by the delay."""

import numpy as np
import pytest

from objectives.margins.trim import Trim
from tests.objectives.margins.designs import HUMMINGBIRD, H, model_of, random_gains

LATE = 3
LEVEL = Trim(hold=False)


def models(trim):
    late = HUMMINGBIRD._replace(dead_time=LATE * H)
    return [model_of("pid", "ladrc", trim=trim, vehicle=vehicle) for vehicle in (HUMMINGBIRD, late)]


def test_delay_margins_shrink_by_the_dead_time():
    """Of loops that only rotors close, by exactly that time; a loop that has less left is not stable."""
    gains = random_gains("pid", "ladrc", 40, 3, 1.3)
    prompt, late = (model.evaluate(gains) for model in models(LEVEL))
    room = prompt.delay.value[:, 3:] - LATE * H
    stable = late.stable[:, 3:]
    assert stable.any() and (~stable).any()
    assert np.array_equal(stable, prompt.stable[:, 3:] & (room > 0.0))
    assert late.delay.value[:, 3:][stable] == pytest.approx(room[stable], rel=1e-6)


def test_the_worst_of_several_vehicles_has_its_own_dead_time():
    gains = random_gains("pid", "ladrc", 10, 3, 0.1)
    late = HUMMINGBIRD._replace(dead_time=LATE * H)
    prompt, worst = (model_of("pid", "ladrc", trim=LEVEL, others=others).evaluate(gains) for others in ((), (late,)))
    stable = worst.stable[:, 3:]
    assert stable.any()
    assert worst.delay.value[:, 3:][stable] == pytest.approx(prompt.delay.value[:, 3:][stable] - LATE * H, rel=1e-6)


@pytest.mark.parametrize("channel", ["roll", "yaw"])
def test_the_loop_is_turned_by_the_delay(channel):
    """L with dead time is L without, times z^-3, at every frequency."""
    (row,) = random_gains("pid", "ladrc", 1, 5, 0.1)
    w = np.geomspace(0.5, 600.0, 40)
    prompt, late = (model.loop(row, channel, frequency=w).loop for model in models(LEVEL))
    assert late == pytest.approx(prompt * np.exp(-1j * w * LATE * H), rel=1e-8)


def test_position_loops_feel_it_through_the_attitude():
    """At hover, with the position loops closed, the same time is taken from the margin of every axis' delay that it decides."""
    (gains,) = [random_gains("pid", "ladrc", 6, 7, 0.1)]
    prompt, late = (model.evaluate(gains) for model in models(Trim()))
    both = prompt.stable & late.stable
    assert both[:, 2].any()
    assert late.delay.value[:, 2][both[:, 2]] == pytest.approx(
        prompt.delay.value[:, 2][both[:, 2]] - LATE * H, rel=1e-6
    )
