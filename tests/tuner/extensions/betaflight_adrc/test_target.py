"""Gains of a study as a file for the command line, and that file on the bench."""

import re

import pytest

from plant.errors import InputError
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.gains import gain_addresses
from tests.tuner.exchange.controllers import controller
from tuner.exchange.registry import settings_of
from tuner.exchange.target import Request
from tuner.extensions.autopilots.firmware import Bench
from tuner.extensions.betaflight_adrc import bench
from tuner.extensions.betaflight_adrc.target import TARGET

FILE = bench.BETAFLIGHT_ADRC.file


def exported(*options, **gains):
    given = controller("pid", "betaflight_adrc", "racer5", period=0.00025, every=16, **gains)
    return TARGET.export(Request(given, "0" * 64, settings_of(TARGET, options)))


def written(content):
    return dict(re.findall(r"^set (\S+) = (\S+)$", content.decode("ascii"), re.MULTILINE))


def both(name, value):
    return {f"roll__{name}": value, f"pitch__{name}": value}


def test_gains_are_the_settings_of_their_names_rounded():
    made = exported(**both("wc", 81.4), yaw__b0=3586.0, **both("limit", 450.0))
    lines = written(made.files[FILE])
    expected = {
        "pid_type": "ADRC",
        "adrc_wc_roll": "81",
        "adrc_wc_yaw": "60",
        "adrc_b0_yaw": "3586",
        "pidsum_limit": "450",
    }
    assert expected.items() <= lines.items()
    assert (lines["adrc_b0_law"], lines["f_roll"], lines["thrust_linear"]) == ("SQRT", "0", "0")
    held = {gain.address: made.held.gains[gain.column] for gain in gain_addresses(made.held.cascade)}
    assert held["roll.wc"] == 81.0 and held["yaw.b0"] == 3586.0 and held["roll.limit"] == 450.0


def test_a_schedule_or_a_motor_lag_is_written_for_builds_that_have_it():
    every = {f"{axis}__schedule": 0.0 for axis in ("roll", "pitch", "yaw")}
    assert "adrc_b0_law" not in written(exported("build=pr-august", **every).files[FILE])
    with pytest.raises(InputError, match="given SQRT; build pr-august has the schedule QUADRATIC alone"):
        exported("build=pr-august")
    assert written(exported("build=mp2", **both("tau", 0.022)).files[FILE])["adrc_motor_tau_ms"] == "22"
    with pytest.raises(InputError, match="given 22 ms; build pr has no motor lag"):
        exported(**both("tau", 0.022))


def test_rollback_is_the_classic_controller():
    assert written(exported().rollback[FILE])["pid_type"] == "CLASSIC"


def bench_in(folder):
    rotors = actuation(controller(airframe="racer5").airframe.vehicle, None)
    return Bench(folder / "program", folder, rotors, 0.00025)


@pytest.fixture
def loaded(monkeypatch, tmp_path):
    """Return the lines that the bench loads into a program with or without the setting of the schedule."""

    def load(content, has_schedules):
        given = []
        monkeypatch.setattr(bench, "_has_schedules", lambda _: has_schedules)
        monkeypatch.setattr(bench.betaflight, "install", lambda _, text: given.append(text))
        bench.install(bench_in(tmp_path), content)
        return given[0]

    return load


class Answers:
    """Command line of a program that has some settings."""

    def __init__(self, *known):
        self.known = known

    def say(self, line):
        return "Allowed values: A, B" if line.removeprefix("get ") in self.known else "###ERROR IN get: INVALID NAME###"

    def close(self):
        pass


@pytest.mark.parametrize(("known", "has_schedules"), [(("pid_type", "adrc_b0_law"), True), (("pid_type",), False)])
def test_a_program_says_whether_it_has_schedules(monkeypatch, tmp_path, known, has_schedules):
    monkeypatch.setattr(bench, "CommandLine", lambda *_: Answers(*known))
    monkeypatch.setattr(bench, "shim_in", lambda folder: folder)
    assert bench._has_schedules(bench_in(tmp_path)) is has_schedules


def test_a_program_without_the_law_is_refused(monkeypatch, tmp_path):
    monkeypatch.setattr(bench, "CommandLine", lambda *_: Answers())
    monkeypatch.setattr(bench, "shim_in", lambda folder: folder)
    with pytest.raises(InputError, match="has no pid_type = ADRC; build pull request 15400"):
        bench._has_schedules(bench_in(tmp_path))


def test_on_the_bench_the_gate_opens_with_the_throttle(loaded):
    lines = loaded(exported().files[FILE], True).decode("ascii").splitlines()
    assert lines[-2:] == ["set adrc_liftoff_throttle = 1", "save"] and "set adrc_b0_law = SQRT" in lines


def test_a_program_with_one_schedule_takes_that_one_alone(loaded):
    quadratic = exported(**{f"{axis}__schedule": 0.0 for axis in ("roll", "pitch", "yaw")}).files[FILE]
    assert "adrc_b0_law" not in written(loaded(quadratic, False))
    with pytest.raises(InputError, match=r"given SQRT; this program has QUADRATIC alone"):
        loaded(exported().files[FILE], False)
