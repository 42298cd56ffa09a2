"""The recommended point and its reason, on made-up held-out values."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tuner.experiments.tuning.conclusion import recommend

STUDY: Any = SimpleNamespace(pick="knee", objectives=[SimpleNamespace(label="error"), SimpleNamespace(label="travel")])
BETTER = "better on held-out flights than the default in every objective"


def recommended(*front: tuple[float, float]) -> tuple[str, str]:
    """Return name and reason of the recommended point of a front beside a default at (10, 10)."""
    values = np.array([(10.0, 10.0), *front])
    finalists: Any = SimpleNamespace(
        evaluation=SimpleNamespace(values=values), non_dominated=np.arange(len(values)) > 0
    )
    names = ["default", *[f"p{i}" for i in range(1, len(values))]]
    row, why = recommend(STUDY, finalists, names)
    return names[row], why


@pytest.mark.parametrize(
    ("front", "point", "why"),
    [
        ([(1, 9), (2, 3), (9, 1)], "p2", f"knee of the held-out front, among points {BETTER}"),
        (
            [(9, 1), (1, 9)],
            "p2",
            "two points have no knee, so the one with the smaller error is taken, "
            f"among points {BETTER}; the other point is p1",
        ),
        ([(1, 9), (20, 1)], "p1", f"the only point that is {BETTER}; the other point is p2"),
        ([(1, 9), (2, 11), (20, 1)], "p1", f"the only point that is {BETTER}"),
        ([(1, 12), (2, 11), (20, 1)], "p2", f"knee of the held-out front, though no point is {BETTER}"),
    ],
)
def test_the_reason_names_the_rule_and_what_it_rests_on(front, point, why):
    assert recommended(*front) == (point, why)
