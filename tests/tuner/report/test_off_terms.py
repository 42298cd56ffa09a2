"""A term that a search turned off stands in the headline, in terminal and page; any other gain at an end does not."""

import json

import pytest

from plant.contract.law_description import every_gain_is_described
from plant.law_registry import LAWS
from tests.tuner.report.fabricate import fabricate
from tests.tuner.report.reading import read
from tuner.documents.tuning import TuningFolder
from tuner.report import write_report
from tuner.report.verdict_text import verdict_text


def with_gain(folder, name, tuned, default=20.0, low=0.0, high=40.0):
    """Return a made-up folder in which the first searched gain has another name and values."""
    fabricate(folder)
    summary = json.loads((folder / "summary.json").read_text())
    old = summary["variables"][0]["name"]
    summary["variables"][0] |= {
        "name": name,
        "tuned": tuned,
        "default": default,
        "low": low,
        "high": high,
        "scale": "linear",
    }
    (folder / "summary.json").write_text(json.dumps(summary))
    gains = json.loads((folder / "gains.json").read_text())
    axis, _, gain = name.partition(".")
    for each in {"attitude": ("roll", "pitch", "yaw"), "position": ("x", "y", "z")}[axis]:
        gains["gains"][f"{each}.{gain}"] = {"value": tuned, "unit": "1"}
    (folder / "gains.json").write_text(json.dumps(gains))
    return TuningFolder(folder), old


SENTENCE = "The search turned the power-rate term of attitude off: attitude.k1 = 0 (default 20)."


def test_a_gain_at_zero_names_its_term(tmp_path):
    results, _ = with_gain(tmp_path / "made", "attitude.k1", 0.0)
    assert verdict_text(results).endswith(SENTENCE)


@pytest.mark.parametrize(
    ("name", "tuned", "default"),
    [
        ("attitude.k1", 0.3, 20.0),
        # A term that was off is not turned off.
        ("attitude.k1", 0.0, 0.0),
        # No term hangs on the width of a saturation.
        ("attitude.delta", 0.0, 0.1),
        ("position.k1", 0.0, 20.0),
    ],
    ids=["small", "off before", "no term", "of another law"],
)
def test_no_other_gain_does(name, tuned, default, tmp_path):
    results, _ = with_gain(tmp_path / "made", name, tuned, default)
    assert "turned" not in verdict_text(results)


def test_the_sentence_is_part_of_the_headline_of_the_page(tmp_path):
    results, old = with_gain(tmp_path / "made", "attitude.k1", 0.0)
    for file in ("candidates.csv", "front.csv"):
        path = results.home / file
        if path.exists():
            path.write_text(path.read_text().replace(f"gain:{old}", "gain:attitude.k1"))
    write_report(results.home)
    assert SENTENCE in read(results.home).text


@pytest.mark.parametrize("name", LAWS)
def test_a_term_is_one_of_a_gain_that_can_be_zero(name):
    assert not list(every_gain_is_described(LAWS[name]))
    for gain in LAWS[name].gains:
        assert not gain.term or (gain.least == 0.0 and not gain.exclusive)


def test_an_integral_and_a_derivative_have_terms_in_every_pid():
    for name in ("pid", "px4", "ardupilot", "betaflight", "crazyflie"):
        terms = {gain.term for gain in LAWS[name].gains}
        assert {"integral term", "derivative term"} - terms <= ({"integral term"} if name == "crazyflie" else set())
