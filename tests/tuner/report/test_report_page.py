"""The page: complete, self-contained, escaped, and with figures that say what the tables say."""

import csv
import json
import re
from math import pi

import numpy as np
import plotly.graph_objects as go
import pytest

from tests.tuner.report.fabricate import fabricate
from tests.tuner.report.reading import read, strings
from tuner.report import write_report
from tuner.report.chart import COLOURS
from tuner.report.loading import load
from tuner.report.numbers import estimate
from tuner.report.page import asset
from tuner.report.response_charts import MOST_INSTANTS, thinned
from tuner.report.results import Fan


def test_nothing_is_fetched(folder):
    page = read(folder)
    for tag, attrs, _ in page.elements:
        assert tag not in ("link", "img", "iframe", "object", "embed", "base", "form")
        assert "src" not in attrs
        assert attrs.get("href", "#").startswith("#")
    style = (folder / "report.html").read_text(encoding="utf-8").split("<style>")[1].split("</style>")[0]
    assert "url(" not in style and "@import" not in style
    policy = next(a["content"] for t, a, _ in page.elements if a.get("http-equiv") == "Content-Security-Policy")
    assert policy.startswith("default-src 'none'") and "http" not in policy and "*" not in policy


def test_plotly_is_there_once_and_the_page_is_of_bearable_size(folder):
    page = read(folder)
    assert sum("plotly.js v" in script for script in page.scripts) == 1
    assert (folder / "report.html").stat().st_size < 7e6


def test_ids_are_unique_and_links_and_figures_find_them(folder):
    page = read(folder)
    assert len(set(page.ids)) == len(page.ids)
    targets = [attrs["href"][1:] for tag, attrs, _ in page.elements if tag == "a"]
    assert targets and set(targets) <= set(page.ids)
    assert set(page.data["charts"]) <= set(page.ids)
    drawn = {attrs["id"] for _, attrs, _ in page.elements if attrs.get("class") == "chart"}
    assert drawn == set(page.data["charts"])


def test_every_quantity_stands_in_the_table(folder):
    page, source = read(folder), (folder / "report.html").read_text(encoding="utf-8")
    summary = json.loads((folder / "summary.json").read_text())
    for row in summary["table"]:
        factor = 180 / pi if row["unit"] == "rad" else 1.0
        assert row["label"] in page.text
        assert row["verdict"] in page.text
        for name in ("default", "tuned"):
            value, interval = estimate(*[factor * row[name][key] for key in ("value", "low", "high")])
            assert value in page.text and interval in page.text
    cells = [" ".join(cell.split()) for cell in re.findall(r'data-label="Unit"><div>(.*?)</div>', source)]
    shown = {"m": "m", "1/s": "1/s", "rad": "°", "s": "s", "1": "–"}
    assert cells[: len(summary["table"])] == [shown[row["unit"]] for row in summary["table"]]
    assert summary["warnings"][0] in page.text
    assert summary["tuned"] in page.text and summary["pick"]["why"] in page.text


def test_gains_can_be_copied_without_loss(folder):
    source = (folder / "report.html").read_text(encoding="utf-8")
    lines = source.split('id="copy-study" tabindex="0">')[1].split("</pre>")[0].replace("&quot;", '"')
    copied = dict(re.findall(r'"([\w.]+)" = (\S+)', lines))
    variables = json.loads((folder / "summary.json").read_text())["variables"]
    assert {name: float(text) for name, text in copied.items()} == {v["name"]: v["tuned"] for v in variables}


def test_embedded_names_are_known(folder):
    data = read(folder).data
    style = asset("page.css")
    for text in strings(data["charts"]):
        if re.fullmatch(r"@[a-z]+(/[\d.]+)?", text):
            # Once for light, once for dark.
            assert style.count(f"--{text[1:].split('/')[0]}: #") == 2
        if text.startswith("#"):
            assert text[1:] in data["shared"]
    assert all(colour.startswith("@") for colour in COLOURS.values())


def resolved(value, shared):
    """Stand in for page.js: names become grey, or arrays."""
    if isinstance(value, str):
        return "#888888" if value.startswith("@") else shared[value[1:]] if value.startswith("#") else value
    if isinstance(value, list):
        return [resolved(entry, shared) for entry in value]
    if isinstance(value, dict):
        if "zip" in value:
            return list(zip(*[shared[name[1:]] for name in value["zip"]], strict=True))
        return {key: resolved(entry, shared) for key, entry in value.items()}
    return value


def test_figures_are_valid_plotly(folder):
    data = read(folder).data
    for chart in data["charts"].values():
        figure = go.Figure(resolved({"data": chart["traces"], "layout": chart["layout"]}, data["shared"]))
        for trace in figure.to_dict()["data"]:
            assert len({len(trace[name]) for name in ("x", "y", "z") if name in trace}) == 1


def front_rows(folder):
    with open(folder / "front.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("role", ["default", "tuned"])
def test_marked_points_stand_at_their_held_out_values(folder, role):
    charts = read(folder).data["charts"]
    row = next(entry for entry in front_rows(folder) if entry["role"] == role)
    table = json.loads((folder / "summary.json").read_text())["table"]
    objectives = [entry for entry in table if entry["kind"] == "objective"]
    factors = [180 / pi if entry["unit"] == "rad" else 1.0 for entry in objectives]
    held_out = [
        float(row[f"held_out:{entry['label']}"]) * factor for entry, factor in zip(objectives, factors, strict=True)
    ]
    if len(objectives) == 1:
        trace = next(t for t in charts["front-ranking"]["traces"] if t["meta"] == {"layer": role})
        assert trace["x"] == pytest.approx(held_out, rel=1e-4)
        return
    pairs = [name for name in charts if re.fullmatch(r"front-\d-\d", name)]
    assert len(pairs) == len(objectives) * (len(objectives) - 1) // 2
    for name in pairs:
        i, j = (int(part) for part in name.split("-")[1:])
        trace = next(t for t in charts[name]["traces"] if t["meta"] == {"layer": role})
        bars = next(t for t in charts[name]["traces"] if t["meta"] == {"layer": role, "also": "intervals"})
        assert (trace["x"][0], trace["y"][0]) == pytest.approx((held_out[i], held_out[j]), rel=1e-4)
        top = float(row[f"high:{objectives[j]['label']}"]) * factors[j]
        assert bars["y"][0] + bars["error_y"]["array"][0] == pytest.approx(top, rel=1e-4)


def test_axes_show_the_front_whole_but_do_not_stretch_for_failed_candidates(folder):
    results = load(folder)
    for name, chart in read(folder).data["charts"].items():
        if re.fullmatch(r"front-\d-\d", name):
            i = int(name.split("-")[1])
            low, high = chart["layout"]["xaxis"]["range"]
            best = results.front.non_dominated
            assert low <= results.front.low[best, i].min() and results.front.high[best, i].max() <= high
            # Failed flights cost 30 times as much in the made-up study; the front and the default lie far below.
            assert high < 0.2 * results.candidates.values[:, i].max()


def test_each_number_of_objectives_has_its_form(folder):
    charts = read(folder).data["charts"]
    count = len(load(folder).objectives)
    assert ("front-ranking" in charts) == (count == 1)
    assert ("front-space" in charts) == (count == 3)
    assert ("front-lines" in charts) == (count > 3)


def test_responses_hold_every_point_scenario_and_signal(folder):
    results, charts = load(folder), read(folder).data["charts"]
    for signal in ("x", "yaw", "rotor4"):
        shown = {
            (trace["meta"].get("point"), trace["meta"]["scenario"])
            for trace in charts[f"response-{signal}"]["traces"]
            if "customdata" in trace
        }
        assert shown == {(point, scenario) for point in ("default", "p0101", "p0103") for scenario in results.scenarios}


def test_angles_of_responses_are_in_degrees_and_rotors_have_no_reference(folder):
    data = read(folder).data
    yaw = next(t for t in data["charts"]["response-yaw"]["traces"] if "point" not in t["meta"])
    assert max(yaw["y"]) == pytest.approx(0.35 * 180 / pi, rel=1e-4)
    assert all("point" in t["meta"] for t in data["charts"]["response-rotor1"]["traces"])


def test_thinned_fans_keep_their_extremes():
    n = 5 * MOST_INSTANTS + 3
    rng = np.random.default_rng(7)
    low = rng.normal(size=n)
    fan = Fan("p", "s", "x", "m", np.arange(n) * 0.004, np.zeros(n), low, low + 1.0, low + 2.0)
    few = thinned(fan)
    assert len(few.time) <= MOST_INSTANTS
    assert (few.low.min(), few.high.max()) == (low.min(), low.max() + 2.0)
    assert few.time[0] == 0.0 and np.all(few.low <= few.median) and np.all(few.median <= few.high)


HOSTILE = "</script><script>alert(1)</script> & \"quotes\" <img src=x onerror='alert(1)'>"


def test_user_text_is_escaped(tmp_path):
    folder = fabricate(tmp_path / "made-up", objectives=4, scenarios=(HOSTILE, "calm"), title=HOSTILE)
    write_report(folder)
    page = read(folder)
    assert sum(tag == "script" for tag, _, _ in page.elements) == 3
    assert not any(tag == "img" or any(name.startswith("on") for name in attrs) for tag, attrs, _ in page.elements)
    assert HOSTILE in page.text
    assert HOSTILE in {attrs.get("value") for tag, attrs, _ in page.elements if tag == "option"}
    charts, shared = page.data["charts"], page.data["shared"]
    assert any(trace["meta"].get("scenario") == HOSTILE for trace in charts["response-x"]["traces"])
    # plotly.js takes a few tags in what it draws.
    drawn = [text for chart in charts.values() for text in strings(chart["layout"])]
    drawn += [text for name, texts in shared.items() if name.startswith("hover-") for text in texts]
    drawn += list(strings(charts["front-lines"]["traces"][0]["x"]))
    assert any("&lt;img" in text for text in drawn) and not any("<img" in text for text in drawn)


def test_missing_responses_are_said(tmp_path):
    folder = fabricate(tmp_path / "made-up", responses=False)
    write_report(folder)
    page = read(folder)
    assert "This folder holds no recorded responses" in page.text
    assert not any(name.startswith("response-") for name in page.data["charts"])
    assert "choose-point" not in page.ids


def test_default_may_remain_the_recommendation(tmp_path):
    folder = fabricate(tmp_path / "made-up")
    summary = json.loads((folder / "summary.json").read_text())
    summary["tuned"], summary["pick"]["why"] = "default", "Nothing was better."
    (folder / "summary.json").write_text(json.dumps(summary))
    write_report(folder)
    assert "The default gains remain the recommendation: Nothing was better." in read(folder).text


def test_same_folder_same_bytes(folder):
    before = (folder / "report.html").read_bytes()
    assert write_report(folder).read_bytes() == before
    assert [path.name for path in folder.glob(".*")] == []
