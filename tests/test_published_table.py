"""The tables of the published problems: who wins by how much, who ended before, evaluations saved."""

import pytest

from benchmarks.search.published.play import PublishedRun, RunKey
from benchmarks.search.published.table import compare, evaluations_to_reach, markdown, median_score, verdicts

NEW, OLD, PEER = "gaussian_process", "gaussian_process at f52a461d", "NOMAD"


def run(*scores: float | None, count: int = 25, stopped: str = "") -> PublishedRun:
    """A run that has the last score from then on."""
    return PublishedRun([*scores, *[scores[-1]] * (count - len(scores))], 2.0, stopped)


RUNS = {
    RunKey("RE21", NEW, 1): run(0.1, 0.5, 0.95),
    RunKey("RE21", NEW, 2): run(0.1, 0.7, 0.85),
    RunKey("RE21", NEW, 3): run(0.1, 0.6, 0.9),
    RunKey("RE21", OLD, 1): run(0.1, 0.2, 0.3, 0.6),
    RunKey("RE21", OLD, 2): run(0.1, 0.2, 0.3, 0.6),
    RunKey("RE21", PEER, 1): run(0.1, 0.9, 0.97, count=8, stopped="ended by its budget of 60 s"),
    RunKey("g6", NEW, 1): run(None, None, 0.2),
    RunKey("g6", OLD, 1): run(None, None, None, None, 0.1),
    RunKey("g6", PEER, 1): run(0.001),
}


@pytest.mark.parametrize(
    ("problem", "score", "other", "expected"),
    [
        ("RE21", 0.9, 0.889, 1),
        ("RE21", 0.9, 0.891, 0),
        ("RE21", 0.889, 0.9, -1),
        ("g6", 0.89, 1.0, 1),
        ("g6", 0.91, 1.0, 0),
        ("g6", float("inf"), 5.0, -1),
        ("g6", float("inf"), float("inf"), 0),
        ("g6", 1e-9, 9e-5, 0),
    ],
)
def test_a_win_needs_a_hundredth_of_the_share_or_a_tenth_of_the_gap(problem, score, other, expected):
    assert compare(problem, score, other) == expected
    assert compare(problem, other, score) == -expected


def test_medians_are_over_the_seeds_that_both_played_and_no_run_counts_beyond_its_end():
    assert median_score(RUNS, "RE21", NEW, 48, {1, 2, 3}) == 0.9
    assert verdicts(RUNS, NEW, PEER, 50) == {"RE21": -1, "g6": -1}
    assert verdicts(RUNS, NEW, PEER, 144) == {"g6": -1}
    assert verdicts(RUNS, NEW, OLD, 50) == {"RE21": 1, "g6": 1}


def test_evaluations_saved_are_read_from_the_median_curve():
    # Medians of seeds 1 and 2: 0.1, 0.6, 0.9; the goal is 0.6, and a gap of 0.1.
    assert evaluations_to_reach(RUNS, "RE21", NEW, OLD) == 24
    assert evaluations_to_reach(RUNS, "g6", NEW, OLD) is None
    assert evaluations_to_reach(RUNS, "g6", PEER, OLD) == 12


def test_the_document_names_losses_and_reasons():
    text = markdown(RUNS, NEW, OLD)
    assert "| NOMAD | 2 | 1 | 1 | 0/0/2 | 0/0/2 | 0/0/1 (1) | 0/0/1 (1) | 2.0 |" in text
    assert "| gaussian_process at f52a461d | 2 | 1-2 | 12 |" in text
    assert "- NOMAD played RE21, g6 only" in text
    assert "- NOMAD: ended by its budget of 60 s (1 runs)" in text
    assert "| RE21 | 0.95, 0.97 NOMAD (1) | 0.95, 0.97 NOMAD (1) |  |  |" in text
    assert "1 of 2 problems get there, with 12.5 times fewer in the median." in text
    assert "RE21 24, g6 never" in text


def test_a_table_can_be_written_where_a_peer_was_never_installed():
    runs = RUNS | {RunKey("RE21", "SMAC", 1): PublishedRun([], 0.0, "not installed: no wheel")}
    assert "- SMAC: not installed: no wheel (1 runs)" in markdown(runs, NEW, OLD)
