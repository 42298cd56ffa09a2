"""A limit on the probability of a loss in a study: reading, the point that is recommended, and the ending where none keeps it."""

import numpy as np
import pytest

from plant.errors import InputError
from tests.tuner.conftest import QUICKSTART, SMALL, run_small
from tuner import extension
from tuner.api.results import TuningResults, open_results
from tuner.cli.printers.run_end import clear_text
from tuner.documents.summary import Summary
from tuner.experiments.tuning.ending import ending_of
from tuner.extensions.tails.estimation.crude import BATCH
from tuner.extensions.tails.limits import MAX_POINTS, FinalistTails, TailLimits, TailValue, confidence_of
from tuner.search.watcher import Watcher
from tuner.study.build import load_study
from tuner.text.numbers import count

LIMIT = {"constraint": [{"metric": "failure", "risk": "probability", "max": 0.05}]}


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        ({"max": 0.5}, "max", "allowed for a probability: 1e-06 to 0.05"),
        ({"max": 0.0}, "max", "allowed for a probability"),
        ({"metric": "noise", "max": 0.01}, "risk", "allowed: of 'failure'"),
    ],
)
def test_a_limit_that_is_none_on_a_rare_loss_is_refused(change, key, words):
    table = {"metric": "failure", "risk": "probability", "max": 1e-4} | change
    with pytest.raises(InputError, match=words) as caught:
        load_study(QUICKSTART, {**SMALL, "constraint": [table]})
    assert caught.value.key == f"constraint[0].{key}"


def test_a_limit_on_a_rare_loss_needs_an_extension_that_estimates_it(monkeypatch):
    table = {"metric": "failure", "risk": "probability", "max": 1e-4}
    monkeypatch.setattr(extension, "extensions", dict)
    with pytest.raises(InputError, match='none is installed; install it, or write risk = "mean"') as caught:
        load_study(QUICKSTART, {**SMALL, "constraint": [table]})
    assert caught.value.key == "constraint[0].risk"
    assert load_study(QUICKSTART, {**SMALL, "constraint": [table | {"risk": "mean"}]}).constraints[0].most == 1e-4


def test_no_objective_is_a_probability():
    table = {"metric": "failure", "risk": "probability"}
    with pytest.raises(
        InputError, match=r"flights of each candidate; limit it in a \[\[constraint\]\].*cvar"
    ) as caught:
        load_study(QUICKSTART, {**SMALL, "objective": [table]})
    assert caught.value.key == "objective[0].risk"


@pytest.fixture(scope="module")
def study():
    return load_study(QUICKSTART, {**SMALL, **LIMIT})


class Listed(TailLimits):
    """Limits whose probabilities are listed by the first gain of a row."""

    def values(self, gains, place):
        assert 0 <= place < MAX_POINTS
        return {0: TailValue(gains[0], 0.5 * gains[0], 2.0 * gains[0], 10, {})}


def test_points_are_judged_until_one_keeps_the_limit(study):
    limits = Listed(study, 1, Watcher())
    judged = FinalistTails(limits, np.array([[0.05], [0.045], [0.02], [0.2]]))
    assert judged.judge(1) and not judged.judge(1) and judged.judge(2)
    # Upper ends of 0.09 and 0.04, at most 0.05.
    assert judged.excess[:, 0] == pytest.approx([0.0, 0.04, 0.0, 0.0])
    assert judged.flights == 20


def test_points_that_are_judged_share_the_error_of_one(study):
    (limit,) = (entry for entry in study.constraints if entry.is_tail)
    errors = [1.0 - confidence_of(limit, place) for place in range(MAX_POINTS)]
    assert sum(errors) == pytest.approx(0.05) and errors == sorted(errors, reverse=True)
    # By chance alone: points at their limit whose upper ends miss it at half the error each, one of them at 2.5 %.
    kept = 1.0 - np.prod([1.0 - 0.5 * error for error in errors])
    assert kept <= 0.025


def test_after_five_points_that_break_it_no_other_counts_as_keeping_it(study):
    judged = FinalistTails(Listed(study, 1, Watcher()), np.full((8, 1), 0.1))
    for row in (3, 1, 4, 2, 6):
        assert np.isfinite(judged.excess).all()
        judged.judge(row)
    assert np.isinf(judged.excess[[0, 5, 7], 0]).all()
    assert judged.excess[[1, 2, 3, 4, 6], 0] == pytest.approx([0.15] * 5)


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tails") / "run"
    # A limit of 5 % takes thousands of flights; a second of each is enough to be counted.
    return run_small(folder, threads=2, constraint=LIMIT["constraint"], scenario__0__duration=1.0), folder


@pytest.mark.slow
def test_a_run_estimates_the_probability_of_what_it_recommends(ran):
    outcome, folder = ran
    row = outcome.table[len(outcome.study.objectives)]
    assert outcome.feasible
    assert row.tail_flights and row.tuned.high <= 0.05
    read = Summary.parse((folder / "summary.json").read_text(encoding="utf-8"))
    assert [entry.tail_flights for entry in read.compared if entry.metric == "failure"] == [row.tail_flights]
    assert row.default.high is not None and row.default.high < 0.2
    spent = f"by {count(row.tail_flights)} flights"
    assert spent in (folder / "report.html").read_text(encoding="utf-8")
    results = open_results(folder)
    assert isinstance(results, TuningResults) and spent in clear_text(results, [row])
    assert any("with a probability of" in text and "at most 0.05 is allowed" in text for text in read.remarks)


@pytest.mark.slow
def test_the_run_records_and_draws_the_tails_of_that_limit(ran):
    outcome, folder = ran
    row = outcome.table[len(outcome.study.objectives)]
    [tail] = row.tails
    assert (tail.tuned.probability, tail.tuned.high, tail.tuned.flights) == (*row.tuned.parts[::2], row.tail_flights)
    assert tail.tuned.curve[-1].level == 1.0 and tail.tuned.curve[-1].probability == row.tuned.value
    assert tail.default_count == row.default_count
    assert tail.default.count is not None and tail.default.count.flights == tail.default.flights == BATCH
    assert tail.default.count.events == 0 and tail.default.high == pytest.approx(1.0 - 0.025 ** (1.0 / BATCH))
    # Half of the error of 5 % is the first point's.
    assert tail.confidence == 0.975
    assert {file.suffix for file in (folder / "figures").glob("tail.*")} == {".png", ".pdf"}
    assert "<h3>Rare losses</h3>" in (folder / "report.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_another_process_comes_to_the_same_estimate(ran, tuner):
    done = tuner("verify", str(ran[1]))
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_run_without_the_limit_estimates_nothing(small_run):
    outcome, _ = small_run
    assert all(row.tail_flights is None for row in outcome.table)


def test_where_no_point_keeps_the_limit_the_ending_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(TailLimits, "values", lambda limits, gains, place: {0: TailValue(0.06, 0.04, 0.08, 1000, {})})
    outcome = run_small(tmp_path / "run", constraint=LIMIT["constraint"])
    assert not outcome.feasible
    row = outcome.table[len(outcome.study.objectives)]
    assert (row.tuned.value, row.tail_flights, row.verdict) == (0.06, 1000, "broken")
    head, violated, *_ = ending_of(outcome)
    assert "none of the" in head
    assert "with 0.08" in violated
