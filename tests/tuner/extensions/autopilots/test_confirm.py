"""Finalists of a small run, confirmed: by a program that flies our own loops, and by Betaflight itself where it is installed.

Both compile the loop that waits for thrusts, 20 s, so they are slow proofs.
"""

import json
import subprocess
import sys
from dataclasses import replace
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tuner
from plant.errors import InputError
from tests.clients import client
from tests.clients.crazyflie_firmware import build
from tests.clients.firmware_sources import checkout
from tests.tuner.conftest import NoDrawing
from tests.tuner.extensions.autopilots.own_loops_program import IN, OUT
from tests.tuner.extensions.autopilots.played import played_in
from tuner.extensions.ardupilot import bench as ardupilot
from tuner.extensions.autopilots import registry
from tuner.extensions.autopilots.registry import firmwares
from tuner.extensions.px4 import bench as px4

SMALL = {
    "search.algorithm": "nsga2",
    "search.population": 8,
    "search.generations": 2,
    "scenario.0.search": 4,
    "scenario.0.held_out": 32,
    "scenario.0.duration": 0.5,
    "margin": [],
}
# A gap of a program that flies the same loops, relative: both are compiled, each in its own order of sums.
ROUNDING = 1e-6


class OwnBoard:
    """A board of the seam around the program that flies our loops."""

    def __init__(self, bench, gains):
        told = json.dumps({"gains": gains, "period": bench.control_period})
        self.rotors = bench.rotors
        self.process: Any = subprocess.Popen(
            [sys.executable, "-m", "tests.tuner.extensions.autopilots.own_loops_program", told],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )

    def arm(self, asked, throttle, held):
        assert 0.0 < throttle < 1.0 and all(0.0 < command < 1.0 for command in held)

    def step(self, asked, throttle):
        lift = self.rotors.thrust_max * throttle**2
        self.process.stdin.write(IN.pack(*asked.angles, *asked.rate, *asked.tilt, asked.yaw, lift))
        self.process.stdin.flush()
        thrusts = OUT.unpack(self.process.stdout.read(OUT.size))
        return tuple(sqrt(thrust / self.rotors.thrust_max) for thrust in thrusts)

    def close(self):
        self.process.stdin.close()
        self.process.wait()
        self.process.stdout.close()


def imported(content, tmp):
    """The gains that the file holds, read back the way a person imports them."""
    file = tmp / "file.txt"
    file.write_bytes(content)
    options = {"loops": "own", "position_every": "16"}
    return list(tuner.import_gains(file, "betaflight", "racer5", options=options).gains.controller.gains)


def small_run_of(study, place, more=None):
    folder = place / "small"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("tuner.experiments.experiment.Drawing", lambda *_, **__: NoDrawing(), raising=False)
        tuner.run(tuner.load_study(study, {**SMALL, **(more or {})}), folder)
    return folder


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A run of Betaflight's own loops."""
    return small_run_of("betaflight", tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="module")
def small_crazyflie(tmp_path_factory):
    """A run of the Crazyflie's own loops."""
    return small_run_of("crazyflie_firmware", tmp_path_factory.mktemp("run"))


@pytest.mark.slow
def test_a_program_that_flies_our_loops_has_our_metrics(small, tmp_path, monkeypatch):
    def install(bench, content):
        gains = imported(content, tmp_path)
        return lambda: OwnBoard(bench, gains)

    monkeypatch.setitem(firmwares(), "ours", replace(firmwares()["betaflight"], name="ours", install=install))
    made = tuner.confirm(small, "ours", sys.executable, finalists=3, flights=2, out=tmp_path / "out")
    assert json.loads((tmp_path / "out" / "confirm.json").read_text()) == json.loads(made.json)
    for quantity, *values in zip(
        made.document.quantities, *(point.values for point in made.document.points), strict=True
    ):
        assert quantity.jitter == 0.0
        for value in values:
            assert value.firmware == pytest.approx(value.model, rel=ROUNDING), quantity.label


@pytest.mark.slow
def test_a_firmware_that_dies_leaves_nothing(small, tmp_path, monkeypatch):
    def install(bench, content):
        raise InputError("ended by itself, with exit code 3", file=bench.binary)

    monkeypatch.setitem(registry.firmwares(), "dead", replace(firmwares()["betaflight"], name="dead", install=install))
    with pytest.raises(InputError, match="exit code 3"):
        tuner.confirm(small, "dead", sys.executable, flights=2, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_betaflight_flies_the_finalists(small, tmp_path):
    """Whole numbers of sticks, gyro and motors, and the thrust curve, are all that stands between: some per cent."""
    site = Path(client("betaflight")).parents[1]
    (binary,) = site.glob("lib/python*/site-packages/betaflight/firmware/obj/betaflight_*_SITL")
    made = tuner.confirm(small, "betaflight", binary, finalists=2, flights=2, out=tmp_path / "out", threads=2)
    document = made.document
    assert [(point.lost_firmware, point.lost_model) for point in document.points] == [(0, 0)] * len(document.points)
    assert all(quantity.jitter == 0.0 for quantity in document.quantities)
    tilt = np.array([[point.values[0].firmware, point.values[0].model] for point in document.points])
    np.testing.assert_allclose(tilt[:, 0], tilt[:, 1], rtol=0.2)
    assert np.all(tilt[:, 0] != tilt[:, 1])
    assert "betaflight" in (tmp_path / "out" / "confirm.md").read_text().lower()


def flown_by(firmware, run, module, out):
    made = tuner.confirm(run, firmware, module, finalists=3, flights=2, out=out).document
    assert [(point.lost_firmware, point.lost_model) for point in made.points] == [(0, 0)] * len(made.points)
    assert all(quantity.jitter == 0.0 for quantity in made.quantities)
    return np.array(
        [
            [[getattr(value, side) for value in point.values[:2]] for point in made.points]
            for side in ("firmware", "model")
        ]
    )


@pytest.mark.slow
def test_a_crazyflie_that_is_played_flies_the_finalists(small_crazyflie, tmp_path):
    """Its gyro is not filtered, ours is at 80 Hz: that is all that stands between, beside whole counts."""
    there, here = flown_by("crazyflie", small_crazyflie, played_in(tmp_path), tmp_path / "out")
    np.testing.assert_allclose(there[:, 0], here[:, 0], rtol=0.1)


@pytest.mark.slow
def test_the_crazyflies_firmware_flies_the_finalists(small_crazyflie, tmp_path):
    """Tilt to parts in a thousand; noise to the second reading of every gyro sample, some per cent."""
    there, here = flown_by("crazyflie", small_crazyflie, build(), tmp_path / "out")
    np.testing.assert_allclose(there[:, 0], here[:, 0], rtol=3e-3)
    np.testing.assert_allclose(there[:, 1], here[:, 1], rtol=0.05)
    assert np.all(there != here)


@pytest.mark.slow
@pytest.mark.parametrize(("firmware", "libraries"), [("px4", px4.LIBRARIES), ("ardupilot", ardupilot.LIBRARIES)])
def test_control_libraries_fly_the_finalists(tmp_path, firmware, libraries):
    """Without a mean wind, for at a tilt of degrees their attitude error in body axes is not our error of angles."""
    sources = checkout(libraries)
    small = small_run_of(firmware, tmp_path, {"scenario.0.air.mean_wind": False})
    there, here = flown_by(firmware, small, sources, tmp_path / "out")
    np.testing.assert_allclose(there, here, rtol=2e-3)
    assert np.all(there != here)


def test_another_law_is_refused_before_anything_flies(small_run, tmp_path):
    with pytest.raises(InputError, match='target = "betaflight"'):
        tuner.confirm(small_run[1], "betaflight", sys.executable, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_program_that_is_missing_is_refused(small_run, tmp_path):
    with pytest.raises(InputError, match="--binary"):
        tuner.confirm(small_run[1], "betaflight", tmp_path / "missing")
