"""The answer of a contest: verdicts are those of the paired differences of its document, limits those that values violate."""

import re

import pytest

from tests.tuner.extensions.contests.report.fabricate_contest import Made, fabricate
from tests.tuner.extensions.contests.report.reading_contest import content
from tests.tuner.report.reading import read
from tuner.extensions.contests.documents import ContestFolder
from tuner.extensions.contests.run import write_contest_report
from tuner.report.comparison.answer import answer_text
from tuner.report.labels import compared_label


@pytest.fixture(scope="module", params=[2, 3])
def contest(request, tmp_path_factory):
    return ContestFolder(fabricate(tmp_path_factory.mktemp("answer") / "made-up", Made(objectives=request.param)))


def test_the_lowest_contender_of_each_objective_is_named_with_the_word(contest):
    document, text = content(contest.home), answer_text(contest)
    for row in (row for row in document["quantities"] if row["kind"] == "objective"):
        values = {e["contender"]: e["value"] for e in document["estimates"] if e["quantity"] == row["label"]}
        lowest = min(values, key=lambda name: values[name])
        pairs = [
            d for d in document["differences"] if d["quantity"] == row["label"] and lowest in (d["first"], d["second"])
        ]
        name = re.escape(compared_label(contest, row["label"]))
        if all(d["lower"] == lowest for d in pairs):
            assert re.search(rf"{re.escape(lowest)} is better than [^;]*{name}", text)
        else:
            assert re.search(
                rf"{re.escape(lowest)} is lowest in [^;]*{name}[^;]*(not distinguishable|without practical difference) from",
                text,
            )


def test_the_page_opens_with_it(contest):
    write_contest_report(contest.home)
    text = read(contest.home).text
    assert 0 < text.find(answer_text(contest)) < text.find("Angles are in degrees")


def test_violated_limits_are_named(contest):
    text = answer_text(contest)
    over = [
        (name, row)
        for (name, label), entry in contest.estimates.items()
        if (row := contest.quantity[label]).limit is not None and entry.value > row.limit
    ]
    assert ("Every limit is satisfied." in text) == (not over)
    for name, row in over:
        assert re.search(
            rf"{re.escape(name)}[^;]* violates? the limit on [^;]*{re.escape(compared_label(contest, row.label))}", text
        )


def test_one_controller_alone_has_no_answer(tmp_path):
    assert answer_text(ContestFolder(fabricate(tmp_path / "alone", Made(names=("PID",), objectives=1)))) == ""
