"""The contract of a control law, run on every law of the registry: a new law inherits all of it."""

from math import hypot
from typing import Any

import numpy as np
import pytest

from plant.backends.stepping import fly_steps, unchanged
from plant.contract.axis import H
from plant.contract.law_contract import AGREES, CLAUSES, Clause
from plant.errors import UnknownNameError
from plant.law_registry import LAWS, law
from plant.laws.law import HELD_COMMAND, Law
from plant.loop import Timing
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.status import Status
from tests.plant.harness import HUMMINGBIRD, LIMITS, TARGETS, batch, default_gains, references, scenario, unmetered

each_law = pytest.mark.parametrize("entry", LAWS.values(), ids=LAWS)
# The backends' agreement has its own tests, beside that of whole cascades.
each_clause = pytest.mark.parametrize(
    "clause", [clause for clause in CLAUSES if clause not in AGREES], ids=lambda clause: clause.__name__
)


def test_a_law_is_found_by_its_name_and_a_misspelt_one_is_helped() -> None:
    assert all(law(name) is entry and entry.name == name for name, entry in LAWS.items())
    with pytest.raises(UnknownNameError, match="did you mean 'hybrid'"):
        law("hybird")


@each_law
@each_clause
def test_it_keeps_the_contract(entry: Law, clause: Clause) -> None:
    assert list(clause(entry)) == []


@each_law
def test_it_tells_how_it_is_sampled_and_shares_gains_with_its_family(entry: Law) -> None:
    assert "\n" not in entry.discretisation and entry.discretisation.endswith(HELD_COMMAND)
    kin = next(other for other in LAWS.values() if other.family == entry.family)
    assert not entry.family or kin.Gains._fields == entry.Gains._fields
    assert len({other.title for other in LAWS.values()}) == len(LAWS)
    for loop in ("attitude", "position"):
        assert entry.defaults(loop) == {gain.name: gain.span(loop).default for gain in entry.gains}


@each_law
def test_default_gains_hold_the_hummingbird_through_a_blow(entry: Law) -> None:
    """Hit for 0.4 s by 2 m/s2 sideways and 8 rad/s2 in roll and pitch, a law that rejects disturbances has it level and on
    its way back 3 s later. RK4 at 4 ms is accurate to 1e-4 here, with rotor lags of 20 ms.
    """
    loop, steps = unmetered(entry.name, entry.name), round(3.4 / H)
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
