"""What every export shares: options, laws, verification after rounding, the folder; shown on exporters made for the purpose."""

import json
import os
from dataclasses import replace

import numpy as np
import pytest

import tuner
from plant.errors import InputError, StoreError
from plant.quadrotor.gains import gain_addresses
from tests.tuner.exchange.controllers import controller, pid
from tuner.exchange.registry import settings_of
from tuner.exchange.run import bundle_of, check_laws
from tuner.exchange.target import Bundle, ExportTarget, HeldParameter, Option, Request, number
from tuner.exchange.verification import quadrotor_loops, verify_export
from tuner.gains import to_document
from tuner.search.watcher import Watcher
from tuner.store.manifest import digest_of


def exporter(held=lambda c: c, parameters=(), options=(), laws=()):
    def bring(request):
        return Bundle(
            {"a.txt": b"a"},
            {"a.txt": b"old"},
            held(request.controller),
            ("Nothing is filtered.",),
            "Paper 1",
            parameters,
        )

    return ExportTarget("paper", "A target made of paper", bring, laws, laws, options)


def request(given):
    return Request(given, "0" * 64, {})


def rounded(step):
    """Hold every gain as a multiple of a step, as a target with integers does."""
    return lambda c: replace(c, gains=tuple(step * round(gain / step) for gain in c.gains))


def written(folder, given):
    file = folder / "gains.json"
    file.write_text(json.dumps(to_document(given, {})))
    return file


OPTIONS = (Option("firmware", "version", ("1", "2")), Option("f", "thrust curve", (), "0.5"))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ((), "--firmware 1 or 2"),
        (("firmware=3",), "allowed: 1, 2"),
        (("firmware",), "NAME=VALUE"),
        (("firmware=1", "firmware=2"), "twice"),
        (("firmware=1", "g=2"), "unknown option of 'paper' 'g'"),
    ],
)
def test_a_wrong_option_is_named(given, words):
    with pytest.raises(InputError, match=words):
        settings_of(exporter(options=OPTIONS), given)


def test_options_have_defaults_and_ranges():
    settings = settings_of(exporter(options=OPTIONS), ("firmware=2",))
    assert settings == {"firmware": "2", "f": "0.5"}
    assert number(settings, "f", 0.0, 1.0, "1") == 0.5
    for text in ("2", "nan", "x"):
        with pytest.raises(InputError, match="--set f"):
            number({"f": text}, "f", 0.0, 1.0, "1")


def test_a_law_that_the_target_lacks_is_refused():
    with pytest.raises(InputError, match="controller.attitude.*hybrid.*pid only"):
        check_laws(exporter(laws=("pid",)), request(controller()))
    check_laws(exporter(laws=("pid",)), request(pid()))
    check_laws(exporter(), request(controller()))


def test_a_parameter_out_of_range_is_refused_by_name():
    parameter = HeldParameter("MC_P", "1", 0.7, 0.7, 0.0, 0.5)
    for held in (0.7, float("nan"), float("inf")):
        with pytest.raises(InputError, match="MC_P"):
            bundle_of(exporter(parameters=(replace(parameter, held=held),)), request(pid()))
    bundle_of(exporter(parameters=(replace(parameter, held=0.5),)), request(pid()))


def verified(asked, target, flights):
    held = target.export(request(asked)).held
    return verify_export(quadrotor_loops(asked), quadrotor_loops(held), flights, Watcher())


def test_what_is_carried_exactly_changes_nothing():
    found = verified(pid(), exporter(), 8)
    assert found.passed
    assert all(row.relative == 0.0 for row in found.gains)
    assert all(row.unrounded == row.held for row in (*found.margins, *found.metrics))
    assert {row.label for row in found.margins} >= {"stable(roll)", "phase_margin(roll)", "gain_up(x)"}


def test_rounding_shows_in_gains_margins_and_flights():
    asked = pid()
    found = verified(asked, exporter(rounded(4.0)), 8)
    by_gain = {row.gain: row for row in found.gains}
    assert by_gain["roll.kp"].held == 88.0 and by_gain["roll.kp"].relative == pytest.approx(-2 / 90)
    assert any(row.unrounded != row.held for row in found.margins)
    assert any(row.difference != 0.0 for row in found.metrics)


def test_rounding_that_breaks_a_limit_is_said():
    """A derivative gain rounded to nothing leaves an angle loop without damping."""

    def without_damping(given):
        columns = {gain.address: gain.column for gain in gain_addresses(given.cascade)}
        gains = np.array(given.gains)
        gains[columns["roll.kd"]] *= 0.02
        return replace(given, gains=tuple(gains.tolist()))

    found = verified(pid(), exporter(without_damping), 4)
    assert not found.passed
    assert "stable(roll)" in found.broken and "stable(pitch)" not in found.broken


def test_a_folder_appears_whole(tmp_path):
    gains = written(tmp_path, pid())
    made = tuner.read_gains(gains).to_export().export(exporter(), (), None, tmp_path / "out", 4)
    assert sorted(p.relative_to(made.folder).as_posix() for p in made.folder.rglob("*") if p.is_file()) == [
        "a.txt",
        "export.json",
        "gains.json",
        "rollback/a.txt",
    ]
    document = json.loads((made.folder / "export.json").read_text())
    assert document["files"] == {"a.txt": digest_of(b"a")}
    assert document["lossy"] == ["Nothing is filtered."]
    record = json.loads((made.folder / "gains.json").read_text())["exports"][-1]
    assert record["target"] == "paper" and record["file"] == "a.txt" and record["sha256"] == digest_of(b"a")


def test_what_stands_there_is_not_touched(tmp_path):
    gains = written(tmp_path, pid())
    out = tmp_path / "out"
    out.mkdir()
    (out / "mine.txt").write_text("mine")
    with pytest.raises(StoreError, match="not touched"):
        tuner.read_gains(gains).to_export().export(exporter(), (), None, out, 4)
    assert [p.name for p in out.iterdir()] == ["mine.txt"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root writes everywhere")
def test_a_folder_that_cannot_be_written_leaves_nothing(tmp_path):
    gains = written(tmp_path, pid())
    shut = tmp_path / "shut"
    shut.mkdir(mode=0o500)
    with pytest.raises(StoreError, match="cannot be written"):
        tuner.read_gains(gains).to_export().export(exporter(), (), None, shut / "out", 4)
    assert list(shut.iterdir()) == []
