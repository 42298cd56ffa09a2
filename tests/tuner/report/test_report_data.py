"""Every number that the page carries for its scripts equals that of the results folder."""

import base64
import csv
import json
from dataclasses import replace
from math import isfinite

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from tests.tuner.report.fabricate import fabricate
from tests.tuner.report.reading import read
from tuner.documents.loading import load
from tuner.report import write_report
from tuner.report.explorer_data import explorer_data
from tuner.report.packed_responses import LEAST, MOST, instants, kept_points
from tuner.report.packing import finite, quantised

JUDGED = (
    "search",
    "held_out",
    "low",
    "high",
    "gap",
    "gap_low",
    "gap_high",
    "difference",
    "difference_low",
    "difference_high",
)


def unpacked(text, kind):
    return np.frombuffer(base64.b64decode(text), dtype=kind)


def number(text):
    value = float(text)
    return value if isfinite(value) else None


def test_points_are_those_of_the_front(folder):
    data = read(folder).data
    with open(folder / "front.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(data["points"])
    labels = [entry["label"] for entry in data["objectives"]]
    for row, point in zip(rows, data["points"], strict=True):
        assert (point["name"], point["role"]) == (row["point"], row["role"])
        assert (str(point["front"]), str(point["feasible"])) == (row["non_dominated"], row["feasible"])
        assert point["probability"] == float(row["probability"])
        assert point["gains"] == [float(row[f"gain:{entry['name']}"]) for entry in data["variables"]]
        for name in JUDGED:
            assert point[name] == [float(row[f"{name}:{label}"]) for label in labels]
        assert point["requirements"] == [number(row["requirement:phase_margin"])]


def test_limits_are_those_of_the_folder(folder):
    data, summary = read(folder).data, json.loads((folder / "summary.json").read_text())
    by_label = {row["label"]: row for row in summary["table"]}
    for entry in data["constraints"] + data["requirements"]:
        assert entry["limit"] == pytest.approx(by_label[entry["label"]]["limit"], rel=1e-15)
    with open(folder / "constraints.csv", newline="", encoding="utf-8") as file:
        found = {(row.pop("point"), row.pop("label")): list(map(float, row.values())) for row in csv.DictReader(file)}
    labels = [entry["label"] for entry in data["constraints"]]
    told = {(p["name"], label): v for p in data["points"] for label, v in zip(labels, p["constraints"], strict=True)}
    assert told == found


def test_candidates_are_those_of_the_generations(folder):
    data = read(folder).data
    table = pd.concat([pd.read_parquet(file) for file in sorted((folder / "generations").iterdir())]).set_index(
        "candidate"
    )
    names = [f"objective:{entry['label']}" for entry in data["objectives"]]
    names += [f"gain:{entry['name']}" for entry in data["variables"]]
    numbers = unpacked(data["candidates"]["number"], "<u4")
    rows = table.loc[numbers]
    for name, packed in zip(names, data["candidates"]["values"], strict=True):
        assert unpacked(packed, "<f4") == pytest.approx(rows[name].to_numpy(), rel=1e-6)
    assert np.array_equal(unpacked(data["candidates"]["state"], "u1") == 1, rows["feasible"])
    finalists = {100 + k for k in range(1, 15)}
    assert set(table.index) - set(numbers) == {c for c in finalists if table.feasible[c]}


def test_responses_are_those_of_the_folder(folder):
    found = read(folder).data["responses"]
    table = pq.read_table(folder / "responses.parquet").to_pandas()
    degrees = np.where(table.unit == "rad", 180.0 / np.pi, 1.0)
    for name in ("low", "median", "high", "worst", "reference"):
        table[name] *= degrees
    groups = dict(tuple(table.groupby(["scenario", "point", "signal"], observed=True)))
    checked = 0
    for scenario in found["scenarios"]:
        time = unpacked(scenario["time"], "<f4")
        for point, fan in scenario["fans"].items():
            assert fan["flight"] == 17
            for signal, packed in zip(found["signals"], fan["signals"], strict=True):
                mine = groups[scenario["name"], point, signal["name"]]
                step = -(-len(mine) // len(time))
                assert time == pytest.approx(mine.time.to_numpy()[::step], abs=1e-6)
                low, size = packed["scale"]
                values = low + size * unpacked(packed["packed"], "<u2").reshape(len(packed["series"]), -1)
                for name, series in zip(packed["series"], values, strict=True):
                    if name in ("median", "worst", "reference"):
                        assert series == pytest.approx(mine[name].to_numpy()[::step], abs=0.51 * size)
                        checked += 1
        for name, packed in scenario["references"].items():
            mine = groups[scenario["name"], "default", name]["reference"].to_numpy()
            low, size = packed["scale"]
            shown = low + size * unpacked(packed["packed"], "<u2")
            assert shown == pytest.approx(mine[:: -(-len(mine) // len(shown))], abs=0.51 * size + 1e-12)
    assert checked == len(found["scenarios"]) * 15 * 10 * 2


def test_loops_are_those_of_the_folder(folder):
    loops = read(folder).data["loops"]
    rows = pq.read_table(folder / "margins.parquet").to_pylist()
    assert unpacked(loops["frequency"], "<f4") == pytest.approx(rows[0]["frequency"], rel=1e-6)
    for row in rows:
        entry = next(loop for loop in loops["points"][row["point"]] if loop["channel"] == row["channel"])
        assert entry["values"] == {quantity["name"]: row[quantity["name"]] for quantity in loops["quantities"]}
        curve = entry.get("curve")
        if curve is None:
            curve = next(o["curve"] for o in loops["points"][row["point"]] if o["channel"] == entry["as"])
        real, imag = unpacked(curve, "<f4").reshape(2, -1)
        assert real == pytest.approx(row["real"], rel=1e-6) and imag == pytest.approx(row["imag"], rel=1e-6)
    assert {loop.get("as") for loop in loops["points"]["default"]} == {None, "x", "roll"}


def test_history_and_gains_are_those_of_the_folder(folder):
    data = read(folder).data
    table = pd.read_csv(folder / "history.csv")
    assert set(data["history"]) == set(table.columns)
    for name, values in data["history"].items():
        assert values == table[name].tolist()
    assert data["gains_file"] == (folder / "gains.json").read_text(encoding="utf-8")
    told = {entry["name"]: entry["addresses"] for entry in data["variables"]}
    assert told["attitude.omega_o"] == ["roll.omega_o", "pitch.omega_o", "yaw.omega_o"]
    assert told["attitude.delta"] == ["roll.delta"] and told["position.zeta"] == []


def test_addresses_and_design_start_as_the_study_says(tmp_path):
    folder = fabricate(tmp_path / "made-up")
    resolved = json.loads((folder / "resolved.json").read_text())
    resolved["variables"] = [
        {"name": "attitude.omega_o", "addresses": ["roll.omega_o"], "low": 1.0, "high": 2.0, "scale": "log"}
    ]
    resolved["search"]["initial"] = ["default", "design"]
    (folder / "resolved.json").write_text(json.dumps(resolved))
    (folder / "start.json").write_text(json.dumps({"points": [], "warnings": [], "digest": ""}))
    results = load(folder)
    assert results.addresses["attitude.omega_o"] == ["roll.omega_o"] and results.start == 1
    write_report(folder)
    candidates = read(folder).data["candidates"]
    assert candidates["start"] and unpacked(candidates["number"], "<u4")[unpacked(candidates["state"], "u1") == 2] == [
        1
    ]
    (folder / "start.json").write_text(
        json.dumps({"points": [], "warnings": ['The starting point "design" is one that ...'], "digest": ""})
    )
    assert load(folder).start is None


def test_sixteen_bits_are_within_half_a_step():
    values = np.random.default_rng(3).normal(size=(3, 500)) * 1e3
    packed = quantised(values)
    back = packed.low + packed.step * unpacked(packed.packed, "<u2").reshape(values.shape)
    assert np.abs(back - values).max() <= 0.5 * packed.step * (1.0 + 1e-9)
    assert packed.step == pytest.approx((values.max() - values.min()) / 65535)
    still = quantised(np.full(4, 2.5))
    assert (still.low, still.step) == (2.5, 0.0) and not unpacked(still.packed, "<u2").any()
    assert finite(np.array([1.0, np.inf, np.nan])) == [1.0, None, None]


def test_many_fans_get_fewer_instants_and_at_last_fewer_points(tmp_path):
    assert instants(10) == MOST and instants(10**6) == LEAST
    assert LEAST < instants(2000) < MOST
    results = load(fabricate(tmp_path / "made-up", finalists=40))
    assert kept_points(results) == set(results.flown_points)
    crowded = replace(results, fans=results.fans * 60)
    kept = kept_points(crowded)
    assert {"default", "p0101"} <= kept and 2 < len(kept) < 41


def test_a_gain_margin_is_a_factor_in_files_and_a_level_on_the_page(tmp_path):
    folder = fabricate(tmp_path / "gains")
    summary = json.loads((folder / "summary.json").read_text())
    row = summary["table"][-1]
    row |= {"unit": "1", "shown_unit": "dB", "limit": 2.0, "default": {**row["default"], "value": 1.5}}
    row |= {"tuned": {**row["tuned"], "value": 4.0}, "difference": {**row["difference"], "value": 2.5}}
    (folder / "summary.json").write_text(json.dumps(summary))
    (shown,) = load(folder).requirements
    assert (shown.unit, shown.decibel) == ("dB", True)
    found = [shown.limit, shown.default.value, shown.tuned.value, shown.difference.value]
    assert found == pytest.approx([6.0206, 3.52183, 12.0412, 8.51937], abs=1e-4)
    (entry,) = explorer_data(load(folder))["requirements"]
    assert (entry["unit"], entry["decibel"], entry["limit"]) == ("dB", True, pytest.approx(2.0))
