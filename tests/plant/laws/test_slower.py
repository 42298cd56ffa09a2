"""A law that steps once in several periods is the law at the longer period, its command held between, on every backend."""

import numpy as np
import pytest

from plant.backends.lanes import compiled
from plant.contract.axis import H, defaults, random_inputs, run
from plant.law_registry import LAWS
from plant.laws.channel import Applied, Channel
from plant.laws.slower import slower
from plant.records import flatten

EVERY = 4


@pytest.mark.parametrize("name", ["pid", "ladrc", "px4"])
def test_it_is_the_law_at_the_longer_period(name: str) -> None:
    law, channel = LAWS[name], Channel(2.0, 0.0)
    given, inputs = defaults(law, "position"), random_inputs(np.random.default_rng(3), 40 * EVERY)
    found, _ = run(slower(law, EVERY), given, inputs, channel)
    # The plain law hears of the mean effect since its last step; before the first one there is one sample.
    parts = [inputs[max(k - EVERY + 1, 0) : k + 1] for k in range(0, len(inputs), EVERY)]
    heard = [
        part[-1]._replace(
            applied=Applied(float(np.mean([i.applied.effect for i in part], axis=0)), part[-1].applied.excess)
        )
        for part in parts
    ]
    expected, _ = run(law, given, heard, channel, EVERY * H)
    np.testing.assert_allclose(found.reshape(-1, EVERY), np.repeat(expected[:, None], EVERY, axis=1), rtol=1e-12)


def test_for_one_period_it_is_the_law_itself() -> None:
    assert slower(LAWS["pid"], 1) is LAWS["pid"]
    slow = slower(LAWS["pid"], 2)
    assert slow.plain is LAWS["pid"] and slow.every == 2 and slow.name == "pid"


def test_compiled_it_gives_the_same() -> None:
    law = slower(LAWS["ladrc"], 3)
    given, inputs = defaults(law, "position"), random_inputs(np.random.default_rng(4), 12)
    step, constants = compiled(law.step), law.prepare(given, H)
    memory = other = law.start(constants, inputs[0].measured, 0.1)
    for entry in inputs:
        arguments = (constants, Channel(2.0, 0.0), entry.setpoint, entry.measured, entry.applied, H)
        (here, memory), (there, other) = law.step(memory, *arguments), step(other, *arguments)
        np.testing.assert_allclose([there, *flatten(other)], [here, *flatten(memory)], rtol=1e-12, atol=1e-12)
