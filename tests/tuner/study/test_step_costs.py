"""Costs of a control step: all processors of all extensions, in gains.json, in words and in a comparison."""

from tuner.study import step_costs
from tuner.study.step_costs import StepCosts, cost_rows, cost_text, first_count

SMALL = StepCosts(
    rows=lambda position, attitude: [{"target": f"small {position} {attitude}"}],
    text=lambda position, attitude, period: f"{period:g} s on the small one",
    count=lambda position, attitude, period: {"target": "small", "period": period},
)
UNCOUNTED = StepCosts(rows=lambda *_: [], text=lambda *_: None, count=lambda *_: None)
LARGE = StepCosts(
    rows=lambda *_: [{"target": "large"}, {"target": "larger"}],
    text=lambda *_: "more on the large one",
    count=lambda *_: {"target": "large"},
)


def answers(monkeypatch, *tables):
    """Rows, text and count of a pair of laws with these processors alone."""
    added = {str(i): table for i, table in enumerate(tables)}
    monkeypatch.setattr(step_costs, "objects", lambda part: added if part == "costs" else {})
    return cost_rows("pid", "adrc"), cost_text("pid", "adrc", 0.5), first_count("pid", "adrc", 0.5)


def test_without_a_processor_there_is_no_cost(monkeypatch):
    assert answers(monkeypatch) == ([], "", None) == answers(monkeypatch, UNCOUNTED)


def test_all_processors_have_a_row_and_a_part_of_the_sentence(monkeypatch):
    rows, text, _ = answers(monkeypatch, SMALL, UNCOUNTED, LARGE)
    assert [row["target"] for row in rows] == ["small pid adrc", "large", "larger"]
    assert text == "0.5 s on the small one; more on the large one"


def test_a_comparison_has_the_first_count(monkeypatch):
    assert answers(monkeypatch, UNCOUNTED, SMALL, LARGE)[2] == {"target": "small", "period": 0.5}
    assert answers(monkeypatch, LARGE, SMALL)[2] == {"target": "large"}
