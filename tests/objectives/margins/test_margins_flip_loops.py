"""Margins reported of random studies, flown: stable at 0.98 of each, unstable at 1.02.

The loops are matrices by differences of flown steps (`flown_loops`), altered in one channel. A gain margin is a level, a phase
margin turns the command by an angle of either sign, and a delay is a queue of whole control periods about the margin.
"""

from collections.abc import Iterator
from math import ceil, floor

import numpy as np
import pytest

from tests.objectives.margins.random_loops import Drawn, drawn_plant, drawn_quadrotor

INSIDE, BEYOND = 0.98, 1.02
# Wider margins are looked at up to here: factors that no vehicle meets.
MAX_FACTOR, MAX_DELAY = 100.0, 200
N_QUADROTORS, N_PLANTS = 160, 40
# In every run: one plant of each kind. The quadrotor of number 3 has position loops at every 7th, 11th and 4th period under
# compute delay.
QUICK_PLANTS = (0, 2, 3, 9)


def contradictions(drawn: Drawn) -> Iterator[str]:
    """Yield each reported margin of each channel that the flown loop contradicts."""
    margins, loop = drawn.margins, drawn.loop

    def value(quantity: str, channel: int) -> float:
        return float(getattr(margins, quantity).value[0, channel])

    if loop.is_stable() != bool(margins.stable.all()):
        yield f"stable: {loop.radius():.9f}"
    for channel, name in enumerate(margins.channels):
        for quantity, sign in (("gain_up", 1.0), ("gain_down", -1.0)):
            factor = value(quantity, channel)
            shares = [(INSIDE, True), (BEYOND, False)] if factor < MAX_FACTOR else []
            for share, rests in shares:
                if loop.is_stable(channel, factor ** (sign * share)) != rests:
                    yield f"{name} {quantity} {factor:.6g} at {share}"
        angle = value("phase", channel)
        for share, rests in [(INSIDE, True), (BEYOND, False)] if angle < np.pi / BEYOND else []:
            both = [loop.is_stable(channel, np.exp(sign * 1j * share * angle)) for sign in (1.0, -1.0)]
            if all(both) != rests:
                yield f"{name} phase {angle:.6g} at {share}"
        periods = value("delay", channel) / drawn.period
        if periods < MAX_DELAY:
            for delay, rests in ((floor(INSIDE * periods), True), (ceil(BEYOND * periods), False)):
                if loop.is_stable(channel, 1.0, delay) != rests:
                    yield f"{name} delay {periods:.6g} at {delay}"


@pytest.mark.slow
@pytest.mark.parametrize("number", range(N_QUADROTORS))
def test_each_margin_of_a_random_quadrotor_flips_its_loop(number: int) -> None:
    drawn = drawn_quadrotor(number)
    assert not list(contradictions(drawn)), drawn.name


@pytest.mark.parametrize(
    "number", [pytest.param(i, marks=[] if i in QUICK_PLANTS else pytest.mark.slow) for i in range(N_PLANTS)]
)
def test_each_margin_of_a_random_plant_flips_its_loop(number: int) -> None:
    drawn = drawn_plant(number)
    assert not list(contradictions(drawn)), drawn.name
