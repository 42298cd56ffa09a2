"""The page: complete, self-contained, escaped. What its scripts do with it: test_report_browser.py; its data: test_report_data.py."""

import json
import re
from math import pi

import numpy as np

from tests.tuner.report.fabricate import fabricate
from tests.tuner.report.reading import read
from tuner.documents.tables import Fan
from tuner.documents.tuning import TuningFolder
from tuner.documents.verdicts import shown_verdict
from tuner.extensions.sensitivity.document import IndexRow, SensitivityDocument
from tuner.report import write_report
from tuner.report.charts.fans import MAX_INSTANTS, thinned
from tuner.report.charts.look import INKS
from tuner.report.labels import in_plain_words, names_of
from tuner.report.page import asset, scripts
from tuner.text.numbers import estimate


def test_nothing_is_fetched(folder):
    page = read(folder)
    for tag, attrs, _ in page.elements:
        assert tag not in ("link", "img", "iframe", "object", "embed", "base", "form")
        assert "src" not in attrs
        assert attrs.get("href", "#").startswith("#")
    style = (folder / "report.html").read_text(encoding="utf-8").split("<style>")[1].split("</style>")[0]
    assert "url(" not in style and "@import" not in style
    policy = next(a["content"] for t, a, _ in page.elements if a.get("http-equiv") == "Content-Security-Policy")
    assert policy.startswith("default-src 'none'") and not any(word in policy for word in ("http", "*", "eval"))


def test_plotly_is_there_once_and_the_page_is_of_bearable_size(folder):
    page = read(folder)
    in_space = "space" in page.ids
    assert f"plotly.js {'' if in_space else '(cartesian - minified) '}v" in page.library[:100]
    assert (folder / "report.html").stat().st_size < (3.6e6 if in_space else 2.3e6)


def test_ids_are_unique_and_links_and_figures_find_them(folder):
    page = read(folder)
    assert len(set(page.ids)) == len(page.ids)
    targets = [attrs["href"][1:] for tag, attrs, _ in page.elements if tag == "a"]
    assert targets and set(targets) <= set(page.ids)
    # Scripts look for these by name.
    wanted = set(re.findall(r'byId\("([a-z-]+)"\)', scripts()))
    known = set(page.ids) | {"space", "matrix", "choose-scenario", "tip"}
    assert wanted <= known, wanted - known


def test_scripts_are_small_and_make_no_markup_of_data():
    from importlib.resources import files

    for file in files("tuner.report").joinpath("js").iterdir():
        source = file.read_text(encoding="utf-8")
        assert len(source.splitlines()) < 200, file.name
        assert source.startswith("// "), file.name
        assert not re.search(
            r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|eval\(|new Function|https?://(?!www\.w3\.org/2000/svg)",
            source,
        )


def test_every_quantity_stands_in_the_table(folder):
    page, source = read(folder), (folder / "report.html").read_text(encoding="utf-8")
    summary = json.loads((folder / "summary.json").read_text())
    for row in summary["table"]:
        factor = 180 / pi if row["unit"] == "rad" else 1.0
        assert row["label"] in page.text
        assert shown_verdict(row["verdict"]) in page.text
        for name in ("default", "tuned"):
            low, middle, high = (
                None if row[name][key] is None else factor * row[name][key] for key in ("low", "value", "high")
            )
            value, interval = estimate(middle, low, high)
            assert value in page.text and interval in page.text
    cells = re.findall(r"</(?:a|span)>(?: \[([^<]*)\])?<small>[^/]*?<code>", source)
    shown = {"deg": "°", "m": "m", "1/s": "1/s", "rad": "°", "s": "s", "1": ""}
    assert cells[: len(summary["table"])] == [shown[row["unit"]] for row in summary["table"]]
    assert in_plain_words(summary["warnings"][0], names_of(TuningFolder(folder))) in page.text
    assert summary["tuned"] in page.text and summary["pick"]["why"] in page.text


def test_gains_can_be_copied_without_loss(folder):
    source = (folder / "report.html").read_text(encoding="utf-8")
    lines = source.split('id="copy-study" tabindex="0">')[1].split("</pre>")[0].replace("&quot;", '"')
    copied = dict(re.findall(r'"([\w.]+)" = (\S+)', lines))
    variables = json.loads((folder / "summary.json").read_text())["variables"]
    assert {name: float(text) for name, text in copied.items()} == {v["name"]: v["tuned"] for v in variables}


def test_colours_of_scripts_are_known():
    style = asset("page.css")
    names = (
        set(re.findall(r'(?:colour|faded)\("(\w+)"', scripts()))
        | {"default", "tuned", "front", "other", "faint"}
        | set(INKS)
    )
    for name in names:
        # Once for light, once for dark.
        assert style.count(f"--{name}: #") == 2, name


def test_thinned_fans_keep_their_extremes():
    n = 5 * MAX_INSTANTS + 3
    rng = np.random.default_rng(7)
    low = rng.normal(size=n)
    fan = Fan("p", "s", "x", "m", np.arange(n) * 0.004, np.zeros(n), low, low + 1.0, low + 2.0)
    few = thinned(fan)
    assert len(few.time) <= MAX_INSTANTS
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
    assert HOSTILE in page.data["responses"]["scenarios"]


def test_missing_responses_are_said(tmp_path):
    folder = fabricate(tmp_path / "made-up", responses=False)
    write_report(folder)
    page = read(folder)
    assert "This folder holds no recorded responses" in page.text
    assert not any(name.startswith("response-") for name in page.ids)
    assert page.data["responses"] is None


def test_missing_margins_are_said(tmp_path):
    folder = fabricate(tmp_path / "made-up", old=True)
    write_report(folder)
    assert "This folder holds no margins of its finalists" in read(folder).text


def test_what_is_known_of_trust_is_told(tmp_path):
    folder = fabricate(tmp_path / "made-up")
    summary = json.loads((folder / "summary.json").read_text())
    limit = {"label": "peak", "unit": "rad", "sense": "max", "limit": 0.1, "relaxed": 0.2}
    summary["screened"], summary["raced"] = {"candidates": 7, "flights": 224}, {"candidates": 3, "flights": 41}
    summary["costs"] = [{"limit": "peak", "objective": "mean(travel)", "unit": "rad", "with": 0.5, "without": 0.25}]
    step = {"candidate": "p0042", "share": 0.5, "limits": [limit]}
    summary["conflict"] = {"sets": [["peak", "ms"]], "single": [step], "common": None}
    (folder / "summary.json").write_text(json.dumps(summary))
    span = {"value": 0.62, "low": 0.51, "high": 0.7}
    index = {"scale": "rank", "output": "mean(travel)", "variable": "position.zeta", "first": span, "total": span}
    analysis = SensitivityDocument(
        title="",
        study="",
        digest="",
        seed=1,
        base_samples=8,
        candidates=8,
        flights=8,
        seconds=1.0,
        lost_flights_percent=0.0,
        not_worth_flying_percent=0.0,
        scales={},
        variables=[],
        outputs=[],
        indices=[IndexRow.model_validate(index)],
        variance=[],
        notes=[],
    )
    (folder / "sensitivity.json").write_text(analysis.text())
    write_report(folder)
    text = read(folder).text
    for told in (
        "224 flights skipped (7 candidates, hard requirement violated)",
        "41 flights skipped (3 candidates, race decided early)",
        "28.65",
        "14.32",
        "peak and ms",
        "p0042",
        "5.73 → 11.46 °",
        "0.62 [0.51, 0.70]",
        "raised one warning",
        "tuner verify made-up",
    ):
        assert told in text, told


def test_default_may_remain_the_recommendation(tmp_path):
    folder = fabricate(tmp_path / "made-up")
    summary = json.loads((folder / "summary.json").read_text())
    summary["tuned"], summary["pick"]["why"] = "default", "Nothing was better."
    (folder / "summary.json").write_text(json.dumps(summary))
    write_report(folder)
    text = read(folder).text
    assert "Keep the default gains: Nothing was better." in text


def test_same_folder_same_bytes(folder):
    before = (folder / "report.html").read_bytes()
    assert write_report(folder).read_bytes() == before
    assert [path.name for path in folder.glob(".*")] == []
