"""The page in a real browser, from disk and without network: linked selection, picking, saving, keys, hostile text, size.

Skipped where Playwright's Python package or a Chromium is missing.
"""

import csv
import json
from math import inf

import numpy as np
import pyarrow.parquet as pq
import pytest

from tests.tuner.report.fabricate import fabricate
from tuner.report import write_report
from tuner.report.screenshots import browser_path, chromium, offline_page
from tuner.text.numbers import estimate, significant

pytest.importorskip("playwright", reason="Playwright's Python package is not installed")
pytestmark = pytest.mark.skipif(browser_path() is None, reason="no Chromium is found on this machine")

# Margins of the plane, see js/11_plane.js.
LEFT, TOP, RIGHT, BOTTOM = 64, 14, 16, 46
HOSTILE = "</script><script>alert(1)</script><img src=x onerror='alert(1)'> & \"quotes\""


@pytest.fixture(scope="module")
def browser():
    with chromium() as started:
        yield started


class Reader:
    """A page of a results folder with what a reader does on it; `complaints`: errors, and requests for anything but files."""

    def __init__(self, browser, folder, width=1280):
        self.folder, self.complaints = folder, []
        self.page = offline_page(browser, width)
        self.page.on("console", lambda m: self.complaints.append(m.text) if m.type in ("error", "warning") else None)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("dialog", lambda dialog: (self.complaints.append(dialog.message), dialog.dismiss()))
        self.page.on(
            "request",
            lambda asked: None if asked.url.startswith(("file:", "blob:")) else self.complaints.append(asked.url),
        )
        self.page.goto((folder / "report.html").resolve().as_uri())
        self.page.wait_for_selector("html[data-ready]", state="attached")

    def data(self):
        return json.loads(
            self.page.inner_text("#data") or self.page.evaluate("document.getElementById('data').textContent")
        )

    def names(self):
        return set(self.page.eval_on_selector_all("#finalists .picker", "all => all.map((one) => one.dataset.point)"))

    def picked(self):
        return self.page.input_value("#choose-point")

    def pick(self, name):
        self.page.click(f'#finalists .picker[data-point="{name}"]')

    def plotted(self, element):
        """The traces that Plotly shows, once they are drawn."""
        self.page.locator(f"#{element}").scroll_into_view_if_needed()
        drawn = (
            "id => { const e = document.getElementById(id); return e.data?.length && !e.hasAttribute('aria-busy'); }"
        )
        self.page.wait_for_function(drawn, arg=element)
        return self.page.evaluate("id => JSON.parse(JSON.stringify(document.getElementById(id).data))", element)

    def picture(self, canvas):
        self.page.locator(f"#{canvas}").scroll_into_view_if_needed()
        self.page.wait_for_timeout(120)
        return self.page.evaluate("id => document.getElementById(id).toDataURL()", canvas)

    def saved(self, button):
        with self.page.expect_download() as download:
            self.page.click(button)
        return download.value.suggested_filename, download.value.path().read_bytes()

    def close(self):
        self.page.context.close()
        assert self.complaints == []


@pytest.fixture
def opened(browser, folder):
    reader = Reader(browser, folder)
    yield reader
    reader.close()


@pytest.fixture(scope="module")
def three(tmp_path_factory):
    folder = fabricate(tmp_path_factory.mktemp("browser") / "three", objectives=3, scenarios=("gusts", "calm air"))
    write_report(folder)
    return folder


@pytest.fixture(scope="module")
def shared(browser, three):
    made = Reader(browser, three)
    yield made
    made.close()


@pytest.fixture
def reader(shared):
    """The page of three objectives as it opens; loading it anew for every test takes long."""
    if shared.page.is_visible("#clear"):
        shared.page.click("#clear")
    for layer in ("searched", "infeasible"):
        shared.page.uncheck(f"[data-layer={layer}]")
    for choice, value in (("choose-point", "p0101"), ("choose-scenario", "0"), ("choose-channel", "0")):
        shared.page.select_option(f"#{choice}", value)
    yield shared
    assert shared.complaints == []


def rows(folder):
    with open(folder / "front.csv", newline="", encoding="utf-8") as file:
        return {row["point"]: row for row in csv.DictReader(file)}


def below(folder, label, level, low=-inf):
    return {name for name, row in rows(folder).items() if low <= float(row[f"held_out:{label}"]) <= level}


def test_page_of_each_number_of_objectives_works_without_network(opened):
    count = len(opened.data()["objectives"])
    assert opened.page.locator("canvas").count() == {1: 2, 2: 2, 3: 4, 4: 3}[count]
    for name in ("gap-0", "progress-hypervolume", "response-0", "loop-nyquist"):
        assert opened.plotted(name)


def test_brush_in_one_view_filters_all_others(reader):
    page, folder = reader.page, reader.folder
    before = {name: reader.picture(name) for name in ("space", "matrix", "parallel")}
    assert set(reader.plotted("gap-1")[1]["marker"]["opacity"]) == {1}
    everything = reader.names()
    first = reader.data()["objectives"][0]
    page.locator("#plane").scroll_into_view_if_needed()
    box = page.locator("#plane").bounding_box()
    left, right = box["x"] + LEFT, box["x"] + box["width"] - RIGHT
    page.mouse.move(left, box["y"] + TOP)
    page.mouse.down()
    page.mouse.move((left + right) / 2, box["y"] + box["height"] - BOTTOM, steps=4)
    page.mouse.up()
    middle = (first["low"] + first["high"]) / 2
    second = reader.data()["objectives"][1]
    low, high = second["low"], second["high"]
    wanted = below(folder, first["label"], middle, first["low"]) & below(folder, second["label"], high, low)
    assert not first["log"] and 0 < len(wanted) < len(everything)
    assert reader.names() == wanted
    assert page.locator("#chips button").count() == 2
    for name, picture in before.items():
        assert reader.picture(name) != picture, name
    opacity = reader.plotted("gap-1")[1]["marker"]["opacity"]
    assert sum(value == 1 for value in opacity) == len(wanted)
    page.click("#clear")
    assert reader.names() == everything


def test_parallel_axis_is_brushed(reader):
    page = reader.page
    page.locator("#parallel").scroll_into_view_if_needed()
    box = page.locator("#parallel").bounding_box()
    middle = box["x"] + box["width"] / 2
    page.mouse.move(middle, box["y"] + box["height"] - 20)
    page.mouse.down()
    page.mouse.move(middle, box["y"] + (46 + box["height"] - 20) / 2, steps=4)
    page.mouse.up()
    second = reader.data()["objectives"][1]
    wanted = below(reader.folder, second["label"], (second["low"] + second["high"]) / 2, second["low"])
    assert reader.names() == wanted and wanted


def test_aspiration_level_filters_and_says_what_is_left(reader):
    page = reader.page
    first = reader.data()["objectives"][0]
    page.fill("#level-0", "400")
    wanted = below(reader.folder, first["label"], first["low"] + 0.4 * (first["high"] - first["low"]))
    assert reader.names() == wanted
    assert page.inner_text("#count").startswith(f"{len(wanted - {'default'})} of 14 finalists")
    page.fill("#level-0", "0")
    assert "comes closest" in page.inner_text("#count")
    page.fill("#level-0", "1000")
    assert len(reader.names()) == 15


def test_candidates_of_the_search_are_shown_on_demand(reader):
    before = reader.picture("plane")
    reader.page.check("[data-layer=infeasible]")
    reader.page.check("[data-layer=searched]")
    assert reader.picture("plane") != before


RED = """id => {
  const canvas = document.getElementById(id);
  const [r, g, b] = getComputedStyle(document.documentElement).getPropertyValue("--bad").trim().match(/[0-9a-f]{2}/gi)
    .map((part) => parseInt(part, 16));
  const { data, width } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  const found = [];
  for (let k = 0; k < data.length; k += 4) {
    const apart = Math.abs(data[k] - r) + Math.abs(data[k + 1] - g) + Math.abs(data[k + 2] - b);
    if (data[k + 3] > 200 && apart < 24) found.push([(k / 4) % width, Math.floor(k / 4 / width)]);
  }
  return { found, width, height: canvas.height };
}"""


@pytest.mark.parametrize("lost", [0, 2])
def test_lost_flights_are_crossed_out_at_the_edge_of_every_view_and_told(browser, tmp_path, lost):
    folder = fabricate(tmp_path / "made-up", objectives=3, lost=lost, responses=False)
    write_report(folder)
    reader = Reader(browser, folder)
    for view in ("plane", "space", "matrix", "parallel"):
        reader.picture(view)
        red = reader.page.evaluate(RED, view)
        assert bool(red["found"]) is bool(lost), view
        if view == "plane" and lost:
            # Forty times the others' values: in the corner at the top right.
            assert all(x > red["width"] - 60 and y < 60 for x, y in red["found"])
            box = reader.page.locator("#plane").bounding_box()
            reader.page.mouse.move(box["x"] + box["width"] - RIGHT, box["y"] + TOP)
            reader.page.wait_for_selector("#tip:not([hidden])")
            assert "lost 2 of 256 held-out flights" in reader.page.inner_text("#tip")
    assert reader.page.locator("#lost-legend").count() == bool(lost)
    assert reader.page.locator("#beyond-legend").is_visible() is bool(lost)
    states = reader.page.inner_text("#finalists")
    assert states.count("lost 2 of 256 held-out flights") == lost
    assert reader.complaints == []


def test_picked_point_shows_its_numbers_gains_responses_and_loops(reader):
    page, folder = reader.page, reader.folder
    reader.pick("p0107")
    row = rows(folder)["p0107"]
    metrics, gains = page.inner_text("#point-metrics"), page.inner_text("#point-gains")
    for entry in reader.data()["objectives"]:
        numbers = [float(row[f"{name}:{entry['label']}"]) * entry["factor"] for name in ("held_out", "low", "high")]
        for text in estimate(*numbers):
            assert text in metrics
    for variable in reader.data()["variables"]:
        assert significant(float(row[f"gain:{variable['name']}"])) in gains
    page.select_option("#choose-scenario", "1")
    table = pq.read_table(folder / "responses.parquet").to_pandas()
    mine = table[(table.point == "p0107") & (table.scenario == "calm air") & (table.signal == "x")]
    drawn = next(trace for trace in reader.plotted("response-0") if trace.get("hovertemplate", "").startswith("p0107"))
    span = float(mine.high.max() - mine.low.min())
    shown = np.interp(mine.time, drawn["x"], drawn["y"])
    assert np.abs(shown - mine["median"]).max() < 0.02 * span
    assert any(trace.get("hovertemplate", "").startswith("worst") for trace in reader.plotted("response-0"))
    assert "p0107 in calm air" in page.inner_text("#responses-of") and "number 17" in page.inner_text("#responses-of")
    loops = {row["point"] + row["channel"]: row for row in pq.read_table(folder / "margins.parquet").to_pylist()}
    page.select_option("#choose-channel", "4")
    nyquist = reader.plotted("loop-nyquist")
    picked = next(trace for trace in nyquist if trace.get("hovertemplate", "").startswith("p0107"))
    assert picked["x"] == pytest.approx(loops["p0107pitch"]["real"], rel=1e-6)
    bode = next(t for t in reader.plotted("loop-gain") if t["hovertemplate"].startswith("p0107"))
    response = np.abs(np.array(loops["p0107pitch"]["real"]) + 1j * np.array(loops["p0107pitch"]["imag"]))
    assert bode["y"] == pytest.approx(20 * np.log10(response), abs=1e-4)
    assert significant(np.degrees(loops["p0107z"]["phase_margin"]), 3) in page.inner_text("#margins")


def test_gains_of_the_recommended_point_are_the_file_of_the_folder(reader):
    wanted = (reader.folder / "gains.json").read_bytes()
    assert reader.saved("#save-tuned") == ("gains.json", wanted)
    assert reader.saved("#save-point") == ("gains.json", wanted)


def test_gains_of_another_point_are_the_same_document_with_its_numbers(reader):
    reader.pick("p0104")
    name, content = reader.saved("#save-point")
    made, base = json.loads(content), json.loads((reader.folder / "gains.json").read_text())
    row = rows(reader.folder)["p0104"]
    assert name == "gains-p0104.json" and list(made) == list(base) and list(made["gains"]) == list(base["gains"])
    assert made["study"] == base["study"] | {"point": "p0104"}
    for axis in ("roll", "pitch", "yaw"):
        assert made["gains"][f"{axis}.omega_o"] == {"value": float(row["gain:attitude.omega_o"]), "unit": "rad/s"}
    assert made["gains"]["roll.delta"]["value"] == float(row["gain:attitude.delta"])
    for entry, before in zip(made["objectives"], base["objectives"], strict=True):
        assert {k: entry[k] for k in ("label", "unit", "kind", "limit")} == {
            k: before[k] for k in ("label", "unit", "kind", "limit")
        }
        if entry["kind"] == "objective":
            told = {"value": "held_out", "low": "low", "high": "high"}
            assert entry["tuned"] == {key: float(row[f"{name}:{entry['label']}"]) for key, name in told.items()}
            assert entry["difference"]["value"] == float(row[f"difference:{entry['label']}"])
    kinds = {entry["label"]: entry for entry in made["objectives"]}
    assert kinds["mean(failure)"]["verdict"] == "kept"
    # The made-up limit on tilt is 0.35 rad, and p0104 is the fifth row: 0.3 + 4 * 0.005.
    assert kinds["quantile95(peak.tilt)"]["tuned"]["value"] == pytest.approx(0.32)
    assert kinds["phase_margin"]["tuned"]["value"] == 34.0 and kinds["phase_margin"]["verdict"] == "broken"


def test_keys_walk_along_the_front_and_let_go_of_the_selection(reader):
    page = reader.page
    label = reader.data()["objectives"][0]["label"]
    order = sorted(rows(reader.folder), key=lambda name: float(rows(reader.folder)[name][f"held_out:{label}"]))
    page.focus("#plane")
    page.keyboard.press("Home")
    assert reader.picked() == order[0]
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    assert reader.picked() == order[2]
    assert page.inner_text("#announcer").startswith(f"Picked {order[2]}")
    page.fill("#level-0", "300")
    page.focus("#plane")
    page.keyboard.press("Escape")
    assert len(reader.names()) == len(order)


def test_everything_that_acts_is_reached_by_tab(reader):
    page, reached = reader.page, set()
    page.evaluate("document.body.focus()")
    for _ in range(160):
        page.keyboard.press("Tab")
        reached.add(page.evaluate("document.activeElement.id"))
    assert {
        "plane",
        "space",
        "parallel",
        "matrix",
        "level-0",
        "axis-x",
        "save-tuned",
        "choose-point",
        "save-point",
    } <= reached


def test_definitions_are_told_on_focus(reader):
    page = reader.page
    page.locator("#levels .term").first.focus()
    assert reader.data()["objectives"][0]["definition"] in page.inner_text("#tip")


def test_numbers_are_written_alike_in_page_and_python(reader):
    cells = reader.page.eval_on_selector_all(
        "#finalists tbody tr", "all => all.map((row) => [row.querySelector('.picker').dataset.point, row.innerText])"
    )
    for name, text in cells:
        for entry in reader.data()["objectives"]:
            row = rows(reader.folder)[name]
            numbers = [float(row[f"{part}:{entry['label']}"]) * entry["factor"] for part in ("held_out", "low", "high")]
            value, interval = estimate(*numbers)
            assert value in text and interval in text


def test_hostile_text_stays_text(browser, tmp_path):
    folder = fabricate(tmp_path / "hostile", objectives=3, scenarios=(HOSTILE, "calm"), title=HOSTILE)
    write_report(folder)
    reader = Reader(browser, folder)
    assert HOSTILE in reader.page.inner_text("h1")
    assert HOSTILE in reader.page.inner_text("#responses-of")
    assert reader.plotted("response-0") and reader.plotted("gap-2")
    assert reader.page.locator("img").count() == 0
    reader.page.locator("#plane").scroll_into_view_if_needed()
    reader.page.hover("#plane")
    reader.page.locator("#levels .term").last.focus()
    assert "onerror" in reader.page.inner_text("#tip")
    reader.close()


SPARSE = {
    "old folder": {"old": True},
    "one point": {"finalists": 1},
    "nothing feasible": {"best": False},
    "no responses": {"responses": False, "objectives": 1},
}


@pytest.mark.parametrize("kind", SPARSE)
def test_sparse_folders_have_sensible_pages(browser, tmp_path, kind):
    folder = fabricate(tmp_path / "sparse", **SPARSE[kind])
    write_report(folder)
    reader = Reader(browser, folder, width=390)
    assert reader.names() == set(rows(folder))
    reader.page.fill("#level-0", "500")
    reader.pick("default") if "default" in reader.names() else reader.page.select_option("#choose-point", "default")
    assert "default gains" in reader.page.inner_text("#point-state")
    text = reader.page.inner_text("body")
    assert not any(word in text for word in ("undefined", "NaN", "null", "[object"))
    assert reader.plotted("gap-0")
    # Nothing is wider than a phone.
    assert reader.page.evaluate("document.documentElement.scrollWidth") <= 390
    reader.close()


@pytest.fixture(scope="module")
def big(tmp_path_factory):
    folder = fabricate(tmp_path_factory.mktemp("big") / "big", objectives=5, population=430, finalists=200)
    write_report(folder)
    return folder


def test_five_objectives_five_thousand_candidates_two_hundred_finalists(browser, big):
    assert (big / "report.html").stat().st_size < 15e6
    reader = Reader(browser, big)
    assert len(reader.names()) == 201 and reader.data()["candidates"]["count"] >= 5000
    reader.page.fill("#level-3", "300")
    assert 0 < len(reader.names()) < 201
    reader.close()


@pytest.mark.slow
def test_the_big_page_is_interactive_within_three_seconds(browser, big):
    reader = Reader(browser, big)
    assert int(reader.page.get_attribute("html", "data-ready")) < 3000
    reader.close()
