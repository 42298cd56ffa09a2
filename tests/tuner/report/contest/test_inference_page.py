"""The page of an inference: every number the one of inference.json; and the same as a section of a contest's page."""

import json
import re
from math import exp

import pytest

from plant.errors import StoreError
from tests.tuner.report.contest.fabricate_contest import fabricate
from tests.tuner.report.contest.fabricate_inference import fabricate_inference, inference
from tests.tuner.report.contest.reading_contest import factor_of, markup_of, said, table_rows
from tests.tuner.report.reading import read
from tuner.cli.read import report as report_command
from tuner.report.charts.strip import StripScale
from tuner.report.contest import write_contest_report, write_inference_report
from tuner.text.numbers import estimate, significant


@pytest.fixture
def folder(tmp_path):
    path = fabricate_inference(tmp_path / "made-up")
    write_inference_report(path)
    return path


def test_page_is_whole_and_offline(folder):
    page = read(folder)
    assert [i for i in page.ids if i.endswith("-title")] == [
        f"{key}-title" for key in ("cells", "unknowns", "ratios", "misfits", "provenance")
    ]
    assert all(attrs.get("href", "#").startswith("#") and "src" not in attrs for _, attrs, _ in page.elements)
    assert {attrs["href"][1:] for tag, attrs, _ in page.elements if tag == "a"} <= set(page.ids)
    text = said(folder)
    for sentence in (inference()["words"][0], "What the open values were", "Made up for tests.", "Settings tried 523"):
        assert sentence in text
    assert "reproduce 1 of 4 printed numbers (before: 0). One number is reproduced by no setting tried." in text
    assert "Seed 2025" in text and "tuner run studies/made.toml" in text
    assert (folder / "report.html").stat().st_size < 1e5


BY = {
    (True, True, True): "✓ inside at the inferred",
    (False, True, True): "≈ inside under a setting that fits about as well",
    (False, False, True): "≈ inside only under settings that fit less",
    (False, False, False): "✗ inside under no",
}


def test_every_cell_says_what_reproduces_it(folder):
    rows = table_rows(folder, "printed")
    for cell in inference()["cells"]:
        row = next(row for row in rows if row[""].startswith(cell["metric"]))
        shown = row[cell["contender"]]
        factor = factor_of(cell["unit"])
        median, ends = estimate(*[factor * cell["ours"][key] for key in ("median", "low95", "high95")])
        before, before_ends = estimate(*[factor * cell["default"][key] for key in ("median", "low95", "high95")])
        assert shown.startswith(f"printed {significant(factor * cell['published'], 6)} ours {median} {ends} ")
        assert (
            BY[tuple(cell[key] for key in ("inside", "consistent", "reproducible"))] in shown
            and f"before {before} {before_ends}" in shown
        )
        nearest = f"nearest median of all settings {significant(0.61 * factor * cell['published'], 3)}"
        assert (nearest in shown) == (not cell["reproducible"])
    assert next(row for row in rows if row[""].startswith("settling"))["ADRC"].strip() == "–"


def test_every_open_value_has_its_range(folder):
    drawings = re.findall(r'class="near".*?', markup_of(folder))
    assert len(drawings) == 2
    for row, known in zip(table_rows(folder, "unknowns"), inference()["unknowns"], strict=True):
        assert row[""].startswith(known["name"]) and known["set"][0] in row[""]
        assert row["Before"].strip() == significant(known["default"], 3)
        assert row["Inferred"].strip() == significant(known["inferred"], 3)
        near = f"{significant(known['near_low'], 3)} to {significant(known['near_high'], 3)}"
        again = f"{significant(known['low68'], 3)} to {significant(known['high68'], 3)}"
        told = row["Identified?"]
        assert (
            near in told
            and again in told
            and {"told": "✓ identified", "loosely": "≈ loosely"}[known["verdict"]] in told
        )
        assert ("reaches an end" in told) == known["at_end"]
        assert (
            f"{significant(known['low'], 3)} {known['scale']} {significant(known['high'], 3)}" in row["Range searched"]
        )
    near = re.search(r'<line x1="([\d.]+)" [^>]*x2="([\d.]+)" [^>]*class="near"', markup_of(folder))
    assert near is not None
    scale = StripScale(0.5, 10.0, True)
    assert [float(end) for end in near.groups()] == pytest.approx(
        [scale.place(0.8 * 4.25), scale.place(1.3 * 4.25)], abs=0.06
    )


def test_ratios_and_misfits(folder):
    ratio, known = table_rows(folder, "ratios")[0], inference()["ratios"][0]
    median, ends = estimate(*[known["ours"][key] for key in ("median", "low95", "high95")])
    assert "ADRC to PID" in ratio[""] and ratio["Printed"].strip() == significant(known["published"])
    assert f"{median} {ends}" in " ".join(ratio["Ours at the inferred setting"].split())
    assert "✗ inside under no setting" in ratio["Reproduced?"] and "nearest median 0.77" in ratio["Reproduced?"]
    told = inference()
    settings = [told["misfit"]["default"], told["misfit"]["inferred"], told["front"][0]]
    for row, setting in zip(table_rows(folder, "misfits"), settings, strict=True):
        for kind in ("peak", "settling", "all"):
            assert row[f"{kind}, search"].strip() == f"× {significant(exp(setting['search'][kind]), 3)}"
            assert row[f"{kind}, held out"].strip() == f"× {significant(exp(setting['held_out'][kind]), 3)}"
        assert row["Inside"].strip() == f"{setting['inside']} of 4"


def test_a_contest_shows_an_inference_beside_it(tmp_path):
    folder = fabricate(tmp_path / "made-up")
    (folder / "inference.json").write_text(json.dumps(inference()))
    write_contest_report(folder)
    page = read(folder)
    assert "Open values inferred" in said(folder) and inference()["words"][0] in said(folder)
    assert {"inference-title", "inference-cells", "inference-unknowns"} <= set(page.ids)
    assert len(set(page.ids)) == len(page.ids)


def test_the_command_draws_an_inference_again(folder, capsys):
    (folder / "report.html").unlink()
    report_command(folder)
    assert capsys.readouterr().out.strip() == str(folder / "report.html")
    assert (folder / "report.html").exists() and (folder / "figures" / "inference.png").stat().st_size > 5000


def test_nothing_to_compare_is_left_out(tmp_path):
    folder = fabricate_inference(tmp_path / "made-up", ratios=[])
    write_inference_report(folder)
    assert "ratios-title" not in read(folder).ids


HOSTILE = "</script><script>alert(1)</script><img src=x onerror='alert(1)'>"


def test_user_text_is_escaped(tmp_path):
    hostile = json.loads(
        json.dumps(inference(HOSTILE)).replace('"PID"', json.dumps(HOSTILE)).replace("omega_c", "<b>x")
    )
    folder = fabricate_inference(tmp_path / "made-up", **hostile)
    write_inference_report(folder)
    page = read(folder)
    assert not any(
        tag in ("img", "b") or any(name.startswith("on") for name in attrs) for tag, attrs, _ in page.elements
    )
    assert HOSTILE in page.text and "<b>x" in page.text


@pytest.mark.parametrize("key", ["unknowns", "cells", "misfit", "settings", "words", "wall_seconds"])
def test_missing_key_is_named(tmp_path, key):
    folder = fabricate_inference(tmp_path / "made-up")
    content = inference()
    del content[key]
    (folder / "inference.json").write_text(json.dumps(content))
    with pytest.raises(StoreError, match=f"inference.json: the key '{key}' is missing"):
        write_inference_report(folder)
