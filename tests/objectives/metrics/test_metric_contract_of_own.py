"""What a metric of one's own breaks is told; every bundled one keeps the same contract."""

from pathlib import Path

import pytest

from objectives.metrics import METRICS
from objectives.metrics.contract import violations_of_metric
from plant.own_code import run_own_code
from tests.plant.own_files import METRIC, SWAY, edited, line_of

VALUE = "value=lambda view: view.meter.iae / view.context.duration"
WRONG = {
    "bound": ("bound=lambda view: view.limit", "bound=lambda view: 0.5 * view.limit", "is exceeded 2 times"),
    "no bound": ("bound=lambda view: view.limit", "bound=lambda view: 0.0", "above 0"),
    "negative": (VALUE, f"{VALUE} - 1.0", "at least 0"),
    "nan": (VALUE, f"{VALUE} * float('nan')", "not finite"),
    "scope": ('scope="axis"', 'scope="axes"', "scope = 'axes'"),
    "name": ('name="mae"', 'name="m a e"', "small letter"),
    "no definition": ('definition="mean of |e| over the flight"', 'definition=""', "definition"),
    "no metric": ("METRIC = Metric(", "METRIC = dict(", "it must be Metric"),
    "error": (VALUE, VALUE.replace("iae", "area"), "no attribute 'area'"),
}


WAY = "state.way + absolute(sample.actual - state.previous)"
WRONG_ACCUMULATOR = {
    "an if": (WAY, "state.way if sample.actual > 0 else 0.0", "write select"),
    "other mathematics": ("absolute(sample", "abs(sample", "write absolute"),
    "arguments": (
        "def update(state, sample, target, t, h):",
        "def update(state, sample, target, t):",
        "it must take 5",
    ),
    "no record": ("Accumulator(Sway,", "Accumulator(tuple,", "write class Sway(NamedTuple)"),
    "no numbers": ("way: float", "way: str", "with numbers"),
    "bound": ("2.0 * view.limit", "view.limit", "is exceeded 2 times"),
    "no accumulator": (
        "accumulator=Accumulator(Sway, start, update)",
        "accumulator=(Sway, start, update)",
        "write Accumulator",
    ),
}


@pytest.mark.parametrize("name", METRICS)
def test_every_bundled_metric_keeps_it(name: str) -> None:
    assert violations_of_metric(METRICS[name], "") == []


@pytest.mark.parametrize("way", WRONG)
def test_what_it_breaks_is_told(way: str, tmp_path: Path) -> None:
    old, new, message = WRONG[way]
    file = edited(METRIC, tmp_path, (old, new))
    told = violations_of_metric(run_own_code(file).names["METRIC"], str(file))
    assert message in told[0].message, told
    assert told[0].place.startswith(str(file))


@pytest.mark.parametrize("way", WRONG_ACCUMULATOR)
def test_what_an_accumulator_breaks_is_told_with_its_line(way: str, tmp_path: Path) -> None:
    old, new, message = WRONG_ACCUMULATOR[way]
    file = edited(SWAY, tmp_path, (old, new))
    told = violations_of_metric(run_own_code(file).names["METRIC"], str(file))
    assert message in told[0].message, told
    assert told[0].place.startswith(str(file))
    if way == "an if":
        assert told[0].place == f"{file}:{line_of(file, 'if sample.actual')}"


@pytest.mark.parametrize("file", [METRIC, SWAY], ids=lambda file: file.stem)
def test_the_shipped_ones_keep_it(file: Path) -> None:
    assert violations_of_metric(run_own_code(file).names["METRIC"], str(file)) == []
