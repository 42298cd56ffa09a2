"""A run's word on the vehicle that it flew draws of: the number that dominates is found, and told wherever results are."""

import pytest

import tuner
from plant.quadrotor.airframes import load
from tests.tuner.in_process import called
from tests.undrawn import undrawn
from tuner.documents.summary import NumberWorth, Summary, UncertaintyCost
from tuner.report.words import uncertainty_words

UNCERTAINTY = """
[uncertainty]
source = "a parts list"
names = ["mass", "lag_up", "lag_down"]
deviations = [0.02, 0.6, 0.6]
correlation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.98], [0.0, 0.98, 1.0]]
"""
STUDY = """
title = "Steps of roll of a vehicle whose rotors nobody has measured"
seed = 3
airframe = { file = "mine.toml" }
controller = { attitude = "hybrid" }
objective = [{ metric = "rms.attitude" }, { metric = "noise" }]
search = { algorithm = "nsga2", population = 8, generations = 2 }

[gains]
"attitude.k1" = {}
"attitude.k2" = {}

[[scenario]]
name = "steps"
duration = 2.0
search = 4
held_out = 64
reference = { kind = "steps", roll_deg = 15.0, time = 0.5 }
air = { intensity = 0.3 }
spread = { from = "airframe" }
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("uncertain")
    (folder / "mine.toml").write_text(load("hummingbird").path.read_text() + UNCERTAINTY)
    (folder / "study.toml").write_text(STUDY)
    with undrawn():
        return tuner.run(folder / "study.toml", folder / "results", threads=2)


def test_the_number_that_dominates_is_the_one_to_measure_next(results):
    row = Summary.read(results.home / "summary.json").uncertainty[0]
    assert row.label == "mean(rms.attitude)" and row.flights == 64 and row.finalists >= 2
    assert row.next.name in ("lag_up", "lag_down") and row.next.shows
    shares = {entry.name: entry.share for entry in row.numbers}
    assert min(shares["lag_up"], shares["lag_down"]) > 0.4 and shares["mass"] < 0.2
    assert row.mean_if_known <= row.mean and row.share >= max(shares.values())


def test_it_is_told_by_the_terminal_and_on_the_page(results):
    said = " ".join(called("show", results.home)[1].split())
    assert "explains" in said and "of the spread" in said
    assert "Value of knowing the vehicle" in (results.home / "report.html").read_text()


def worth(name, value, share):
    return NumberWorth(name=name, value=value, told=value > 0.0, share=share, shows=share > 0.1)


@pytest.mark.parametrize(
    ("known", "numbers", "said"),
    [
        (
            1.9,
            [worth("lag_up", 0.06, 0.4)],
            "costs 5.0 % of its mean among 7 finalists. Measure lag_up next: it alone is worth 3.0 %; ",
        ),
        (
            1.9,
            [worth("mass", 0.0, 0.2)],
            "Measure mass next: none is worth much alone; mass explains 20 % of the spread.",
        ),
        (2.0, [worth("mass", 0.0, 0.02)], "would change no choice among 7 finalists; no number shows in the spread."),
    ],
)
def test_the_sentence_says_what_it_costs_and_what_to_measure(known, numbers, said):
    row = UncertaintyCost(
        label="mean(noise)",
        unit="1",
        finalists=7,
        flights=64,
        mean=2.0,
        known=known,
        told=known < 2.0,
        share=0.5,
        numbers=numbers,
    )
    assert said in uncertainty_words(row)
