"""Rounding alone decides nothing: what is named stays the same when every value moves in its last digits."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plant.ties import TIE, first_largest, first_smallest, increasing_order

NUMBERS = st.lists(st.sampled_from([0.0, 1.0, 1.5, -2.0, 3e6, 4e-7]), min_size=1, max_size=12)


@given(NUMBERS, st.integers(0, 2**32 - 1))
def test_moved_by_rounding_the_same_places_are_named(values: list[float], seed: int) -> None:
    exact = np.array(values)
    moved = exact * (1.0 + 1e-15 * np.random.default_rng(seed).uniform(-4.0, 4.0, len(exact)))
    assert first_smallest(moved) == values.index(min(values))
    assert first_largest(moved) == values.index(max(values))
    assert increasing_order(moved).tolist() == np.argsort(exact, kind="stable").tolist()


def test_what_differs_by_more_than_a_tie_is_decided_by_value() -> None:
    values = np.array([1.0 + 3.0 * TIE, 1.0])
    assert first_smallest(values) == 1 and increasing_order(values).tolist() == [1, 0]
    assert first_largest(-values) == 1


def test_sums_that_cancel_are_equal_by_the_size_of_their_terms() -> None:
    values = np.array([3e-16, -1e-16, 0.5])
    assert first_smallest(values) == 1 and first_smallest(values, scale=1.0) == 0


@pytest.mark.parametrize("values", [[np.inf, np.inf], [np.inf, -np.inf, -np.inf], [np.nan, np.nan]])
def test_infinite_and_missing_values_name_their_first_place(values: list[float]) -> None:
    exact = np.array(values)
    assert first_smallest(exact) == int(np.argmin(exact))
    assert increasing_order(exact).tolist() == np.argsort(exact, kind="stable").tolist()


ROOMS = ("experiments", "api", "report", "cli", "documents")
FACES = ("api", "charts", "command", "document", "page", "panels", "printer", "run", "section")
"""Ends of the names of an extension's modules that are what such rooms hold."""
STRUCTURAL = {
    "tuner/experiments/tuning/survivors.py": 1,  # numbers of scenarios
    "tuner/experiments/compare/tables.py": 1,  # the first row of a name
    "tuner/extensions/first_flights/confirmation_api.py": 1,  # whole numbers of places
    "tuner/extensions/identification/charts.py": 1,  # which curves of a figure are drawn
    "tuner/report/comparison/fronts_panels.py": 1,  # points of a line from left to right
    "tuner/documents/tables.py": 3,  # codes of names
}
"""Files of rooms that name points, with their lines that order no results of flights."""


def test_rooms_that_name_points_do_so_by_ties() -> None:
    root = Path(__file__).parents[2]
    files = [
        *(path for room in ROOMS for path in (root / "tuner" / room).rglob("*.py")),
        *(path for path in (root / "tuner/extensions").rglob("*.py") if path.stem.endswith(FACES)),
        root / "tuner/search/front.py",
    ]
    pattern = re.compile(r"argmin|argmax|argsort")
    counts = {str(path.relative_to(root)): len(pattern.findall(path.read_text(encoding="utf-8"))) for path in files}
    assert {name: count for name, count in counts.items() if count} == STRUCTURAL
