"""Every number that the page carries for its scripts equals that of the results folder."""

import base64
import csv
import json
from functools import cache
from math import isfinite
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.tables import read_frame, read_rows
from tests.tuner.report.fabricate import fabricate
from tests.tuner.report.reading import array_of, read
from tuner.documents.parts import is_level
from tuner.documents.tuning import TuningFolder
from tuner.report import write_report
from tuner.report.charts.loops import gain_of, phase_of
from tuner.report.charts.web import Arrays, finite, quantised
from tuner.report.explorer_data import explorer_data, limited_quantities
from tuner.report.tuning_charts import MAX_INSTANTS, MIN_INSTANTS, instants, kept_points
from tuner.text.numbers import MISSING, significant

FACTORS = {"m": 1.0, "s": 1.0, "1/s": 1.0, "°": 180.0 / np.pi, "°² s": (180.0 / np.pi) ** 2}

TITLES = {"default": "default gains", "p0101": "tuned gains (p0101)"}


@cache
def data_of(folder):
    """The numbers on the page of a folder that no test writes into."""
    return read(folder).data


def unpacked(text, kind):
    return np.frombuffer(base64.b64decode(text), dtype=kind)


def assert_near(mine, wanted, rel=0.0, off=0.0):
    """Assert that arrays of one shape are near each other; pytest's own way takes 0.1 ms a number."""
    np.testing.assert_allclose(mine, wanted, rtol=rel, atol=off, equal_nan=False)


def number(text):
    value = float(text)
    return value if isfinite(value) else None


def code_of(entry):
    """The name of a quantity in files, which its definition begins with."""
    return entry["definition"].split(": ")[0]


def test_points_are_those_of_the_front(folder):
    data = data_of(folder)
    with open(folder / "front.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(data["points"])
    labels = [code_of(entry) for entry in data["objectives"]]
    for row, point in zip(rows, data["points"], strict=True):
        assert (point["name"], point["role"]) == (row["point"], row["role"])
        assert (str(point["front"]), str(point["feasible"])) == (row["non_dominated"], row["feasible"])
        assert point["probability"] == float(row["probability"])
        assert point["gains"] == [float(row[f"gain:{entry['name']}"]) for entry in data["variables"]]
        for name in ("held_out", "low", "high"):
            assert point[name] == pytest.approx(
                [
                    float(row[f"{name}:{label}"]) * FACTORS[entry["unit"]]
                    for label, entry in zip(labels, data["objectives"], strict=True)
                ]
            )
        patch = {entry["label"]: entry for entry in point["patch"]}
        for label in labels:
            told = [
                patch[label]["tuned"]["value"],
                *[patch[label]["difference"][end] for end in ("value", "low", "high")],
            ]
            names = ("held_out", "difference", "difference_low", "difference_high")
            assert told == [float(row[f"{name}:{label}"]) for name in names]
        assert patch["phase_margin"]["tuned"]["value"] == number(row["requirement:phase_margin"])


def test_limited_quantities_are_those_of_the_folder(folder):
    data, summary = data_of(folder), json.loads((folder / "summary.json").read_text())
    assert [code_of(entry) for entry in data["quantities"]] == [row["label"] for row in summary["table"]]
    assert not any(entry["label"].startswith(code_of(entry)) for entry in data["quantities"])
    with open(folder / "constraints.csv", newline="", encoding="utf-8") as file:
        found = {(row.pop("point"), row.pop("label")): list(map(float, row.values())) for row in csv.DictReader(file)}
    told = {
        (point["name"], row["label"]): [
            row[key][end] for key in ("tuned", "difference") for end in ("value", "low", "high")
        ]
        for point in data["points"]
        for row in point["patch"]
        if row["kind"] == "constraint"
    }
    assert told == found


def test_finalists_carry_what_is_limited(folder):
    data = data_of(folder)
    assert {code_of(entry) for entry in data["limits"]} <= {code_of(entry) for entry in data["quantities"]}
    for entry, column in zip(
        data["limits"], zip(*[point["limited"] for point in data["points"]], strict=True), strict=True
    ):
        assert entry["low"] < entry["high"] and len(set(column)) > 1
        row = next(k for k, other in enumerate(data["points"][0]["patch"]) if other["label"] == code_of(entry))
        cells = [point["texts"]["quantities"][row]["value"][0] for point in data["points"]]
        assert [value is None for value in column] == [text == MISSING for text in cells]
        shown = [(value, float(text)) for value, text in zip(column, cells, strict=True) if value is not None]
        assert [value for value, _ in shown] == pytest.approx([number for _, number in shown], rel=0.02)


def test_candidates_are_those_of_the_generations(folder):
    data = data_of(folder)
    table = pd.concat([read_frame(file) for file in sorted((folder / "generations").iterdir())]).set_index("candidate")
    names = [f"objective:{code_of(entry)}" for entry in data["objectives"]]
    factors = [FACTORS[entry["unit"]] for entry in data["objectives"]] + [1.0] * len(data["variables"])
    names += [f"gain:{entry['name']}" for entry in data["variables"]]
    # The search records margins of all candidates, but limits on flights only as what breaks them.
    of_flights, margin = data["limits"]
    assert code_of(of_flights) == "quantile95(peak.tilt)" and code_of(margin) == "phase_margin"
    names, factors = [*names, "requirement:phase_margin"], [*factors, FACTORS[margin["unit"]]]
    numbers = unpacked(data["candidates"]["number"], "<u4")
    rows = table.loc[numbers]
    columns = [unpacked(packed, "<f4") for packed in data["candidates"]["values"]]
    assert np.isnan(columns.pop(-2)).all()
    for name, factor, column in zip(names, factors, columns, strict=True):
        assert_near(column, factor * rows[name].to_numpy(), rel=1e-6)
    assert np.array_equal(unpacked(data["candidates"]["state"], "u1") == 1, rows["feasible"])
    finalists = {100 + k for k in range(1, 15)}
    assert set(table.index) - set(numbers) == {c for c in finalists if table.feasible[c]}


def marks(data, panel, **show):
    """The traces of a panel that are seen under some choices, with their arrays."""
    for trace in data["charts"][panel]["traces"]:
        meta = trace["meta"]
        if all(key in meta and (meta[key] == value or value in meta[key]) for key, value in show.items()):
            series = {
                key: np.array(array_of(data["arrays"][trace[key][1:]]))
                for key in ("x", "y")
                if isinstance(trace[key], str)
            }
            yield trace, series


def test_responses_are_those_of_the_folder(folder):
    data = data_of(folder)
    table = read_frame(folder / "responses.npz")
    degrees = np.where(table.unit == "rad", 180.0 / np.pi, 1.0)
    for name in ("low", "median", "high", "worst", "reference"):
        table[name] *= degrees
    signals = [signal for signal in dict.fromkeys(table.signal) if not signal.startswith("rotor")]
    signals += [signal for signal in dict.fromkeys(table.signal) if signal.startswith("rotor")]
    checked = 0
    groups: Any = table.groupby(["scenario", "point", "signal"], observed=True)
    for (scenario, point, signal), mine in groups:
        assert data["responses"]["flights"][scenario][point] == 17
        found = list(marks(data, f"response-{signals.index(signal)}", scenario=scenario, point=point))
        low, high, worst, median = [
            entry for entry in found if not entry[0].get("hovertemplate", "").startswith("reference")
        ]
        title = TITLES.get(point, point)
        assert median[0]["hovertemplate"].startswith(f"{title}: ")
        assert worst[0]["hovertemplate"].startswith(f"worst case of {title}: ")
        assert high[0]["fill"] == "tonexty" and low[1]["y"].min() == pytest.approx(
            mine.low.min(), abs=1e-4 * np.ptp(mine.high)
        )
        step = -(-len(mine) // len(median[1]["x"]))
        for name, (_, series) in (("median", median), ("worst", worst)):
            assert_near(series["x"], mine.time.to_numpy()[::step], off=1e-6)
            assert_near(series["y"], mine[name].to_numpy()[::step], off=1e-5 * (np.ptp(mine[name]) + 1e-9))
            checked += 1
    assert checked == len(data["responses"]["scenarios"]) * 15 * 10 * 2


def test_the_top_view_has_the_tracks_of_the_folder(folder):
    data = data_of(folder)
    table: Any = read_frame(folder / "responses.npz")
    for point in ("default", "p0104"):
        mine = {
            signal: table[(table.scenario == "gusts") & (table.point == point) & (table.signal == signal)]
            for signal in "xy"
        }
        median, worst = [series for _, series in marks(data, "top-view", scenario="gusts", point=point)]
        step = -(-len(mine["x"]) // len(median["x"]))
        for name, series in (("median", median), ("worst", worst)):
            for signal in "xy":
                assert_near(series[signal], mine[signal][name].to_numpy()[::step], off=1e-4)


def test_loops_are_those_of_the_folder(folder):
    data = data_of(folder)
    rows = read_rows(folder / "margins.npz")
    for row in rows:
        point = next(point for point in data["points"] if point["name"] == row["point"])
        channel, stable, *texts, _ = next(loop for loop in point["texts"]["loops"] if loop[0] == row["channel"])
        assert (channel, stable) == (row["channel"], "yes" if row["stable"] else "no")
        at = [name for name, _ in data["margins"]].index("phase margin [°]")
        phase = row["phase_margin"]
        assert texts[at] == ("∞" if phase is None else significant(np.degrees(phase), 3))
        loop = np.array(row["real"]) + 1j * np.array(row["imag"])
        wanted = {
            "gain": (row["frequency"], gain_of(loop)),
            "phase": (row["frequency"], phase_of(loop)),
            "nyquist": (loop.real, loop.imag),
        }
        for name, (x, y) in wanted.items():
            found = marks(data, f"loop-{name}", point=row["point"], channel=row["channel"])
            (curve,) = [series for trace, series in found if trace["mode"] == "lines"]
            assert_near(curve["x"], x, rel=1e-6)
            assert_near(curve["y"], y, rel=1e-6)
    shared = {tuple(t["meta"]["channel"]) for t, _ in marks(data, "loop-gain", point="default")}
    assert ("x", "y") in shared and ("roll", "pitch") in shared


def test_history_and_gains_are_those_of_the_folder(folder):
    data = data_of(folder)
    table = pd.read_csv(folder / "history.csv")
    shown = {"progress-hypervolume": table.hypervolume, "progress-feasible": 100.0 * table.feasible_share}
    for name, values in shown.items():
        ((_, series),) = marks(data, name)
        assert series["x"].tolist() == table.generation.tolist() and series["y"] == pytest.approx(values, rel=1e-6)
    bars = [series["y"].tolist() for _, series in marks(data, "progress-saved")]
    assert bars == [table[name].tolist() for name in ("flights", "flights_raced", "flights_saved")]
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
    results = TuningFolder(folder)
    assert results.addresses["attitude.omega_o"] == ["roll.omega_o"] and results.start == 1
    write_report(folder)
    candidates = read(folder).data["candidates"]
    assert candidates["start"] and unpacked(candidates["number"], "<u4")[unpacked(candidates["state"], "u1") == 2] == [
        1
    ]
    (folder / "start.json").write_text(
        json.dumps({"points": [], "warnings": ['The starting point "design" is one that ...'], "digest": ""})
    )
    assert TuningFolder(folder).start is None


def test_sixteen_bits_are_within_half_a_step():
    values = np.random.default_rng(3).normal(size=1500) * 1e3
    stored = quantised(values)
    assert np.abs(np.array(array_of(stored)) - values).max() <= 0.5 * stored["scale"][1] * (1.0 + 1e-9)
    assert stored["scale"][1] == pytest.approx((values.max() - values.min()) / 65535)
    assert quantised(np.full(4, 2.5))["scale"] == [2.5, 0.0] and array_of(quantised(np.full(4, 2.5))) == [2.5] * 4
    assert finite(np.array([1.0, np.inf, np.nan])) == [1.0, None, None]


def test_many_fans_get_fewer_instants_and_at_last_fewer_points(tmp_path):
    assert instants(10) == MAX_INSTANTS and instants(10**6) == MIN_INSTANTS
    assert MIN_INSTANTS < instants(2000) < MAX_INSTANTS
    results = TuningFolder(fabricate(tmp_path / "made-up", finalists=40))
    assert kept_points(results) == set(results.flown_points)
    results.fans = results.fans * 60
    kept = kept_points(results)
    assert {"default", "p0101"} <= kept and 2 < len(kept) < 41


def test_a_gain_margin_is_a_factor_in_files_and_a_level_on_the_page(tmp_path):
    folder = fabricate(tmp_path / "gains")
    summary = json.loads((folder / "summary.json").read_text())
    row = summary["table"][-1]
    row |= {"unit": "1", "shown_unit": "dB", "limit": 2.0, "default": {**row["default"], "value": 1.5}}
    row |= {"tuned": {**row["tuned"], "value": 4.0}, "difference": {**row["difference"], "value": 2.5}}
    (folder / "summary.json").write_text(json.dumps(summary))
    (shown,) = TuningFolder(folder).requirements
    assert (shown.unit, is_level(shown)) == ("dB", True)
    found = [shown.limit, shown.default.value, shown.tuned.value, shown.difference.value]
    assert found == pytest.approx([6.0206, 3.52183, 12.0412, 8.51937], abs=1e-4)
    results = TuningFolder(folder)
    quantities: Any = explorer_data(results, limited_quantities(results), {}, Arrays())["quantities"]
    entry = quantities[-1]
    assert (entry["unit"], entry["limit"]) == ("dB", "min 6.0206")
