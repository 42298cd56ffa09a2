"""The target's low-pass of the gyro in the margins: its lag is that of the filter written out, and what breaks is said."""

import json
from typing import Any

import numpy as np
import pytest
from scipy.signal import TransferFunction, butter, freqresp

from objectives.margins.trim import Trim
from plant.vectors import Vec3
from tests.tuner.exchange.controllers import pid
from tests.tuner.in_process import tuner
from tuner.analysis.margins.readings import subject_of
from tuner.cli.printers.export import said_of_filter
from tuner.documents.export import GyroFilterPart, VerificationPart
from tuner.extensions.autopilots.gyro_filter import equal_lag, filter_rows, with_filter
from tuner.extensions.autopilots.pid import axis_gains
from tuner.gains import to_document


def butterworth(frequency, cutoff):
    """Response of the analogue filter of second order at a frequency [rad/s]; cutoff [Hz]."""
    coefficients: Any = butter(2, 2.0 * np.pi * cutoff, analog=True)
    system = TransferFunction(*coefficients)
    found: Any = freqresp(system, [frequency])
    return found[1][0]


@pytest.mark.parametrize("cutoff", [20.0, 40.0, 80.0])
@pytest.mark.parametrize("crossover", [1.0, 15.0, 40.0])
def test_the_lag_is_that_of_a_butterworth_filter(crossover, cutoff):
    theirs = np.angle(butterworth(crossover, cutoff))
    assert -np.arctan(crossover * equal_lag(crossover, cutoff)) == pytest.approx(theirs, rel=1e-12)


def test_the_phase_that_it_takes_is_that_of_the_law_with_the_filter_on_its_rate():
    """kp + ki/s + kd s F(s) at the crossover, with our F and with theirs; the crossover moves little for so small a change."""
    given = pid("iris", period=0.0025)
    rows = {row.loop: row for row in filter_rows(given, 60.0)}
    assert set(rows) == {"x", "y", "z", "roll", "pitch", "yaw"}
    gains = axis_gains(given, "roll")
    still = Vec3(0.0, 0.0, 0.0)
    subject = subject_of(given, Trim(0.0, still, still, True))
    w = float(subject.margins.crossover.value[0, 3])
    s, theirs = 1j * w, butterworth(w, 60.0)
    ours = 1.0 / (1.0 + gains.t_f * s)
    phases = [np.angle(gains.kp + gains.ki / s + gains.kd * s * filtered, deg=True) for filtered in (ours, theirs)]
    assert rows["roll"].taken == pytest.approx(np.radians(phases[0] - phases[1]), abs=np.radians(0.5))
    assert rows["z"].taken == pytest.approx(0.0, abs=1e-9)
    assert all(row.taken == pytest.approx(row.ours - row.theirs) for row in rows.values())
    slower = with_filter(given, subject, 10.0)
    assert axis_gains(slower, "roll").t_f > axis_gains(with_filter(given, subject, 60.0), "roll").t_f


def test_a_filter_that_is_off_takes_nothing():
    assert filter_rows(pid("iris"), 0.0) == []


def test_what_it_breaks_is_said():
    shown = {"limit": 35.0, "ours": 35.27, "theirs": 34.6, "taken": 0.67, "spare": 0.27}
    row = {"loop": "y", "unit": "rad", **{key: np.radians(value) for key, value in shown.items()}}

    def verified(**last):
        gyro = {"name": "INS_GYRO_FILTER", "cutoff": 20.0, "known": False, "rows": [{**row, **last}]}
        return VerificationPart.model_construct(gyro_filter=GyroFilterPart.model_validate(gyro))

    told = said_of_filter(verified(breaks=True))
    assert "INS_GYRO_FILTER = 20 Hz (the default)" in told[0] and "y 0.67 of 0.27" in told[0]
    assert told[1].startswith("Warning: ") and "y 34.6 deg" in told[1]
    assert len(said_of_filter(verified(breaks=False))) == 1
    assert said_of_filter(VerificationPart.model_construct(gyro_filter=None)) == []


def test_an_export_says_that_rounding_alone_was_verified(tmp_path, monkeypatch, capsys):
    file = tmp_path / "gains.json"
    file.write_text(json.dumps(to_document(pid(period=0.002), {})))
    code, told, _ = tuner(
        monkeypatch, capsys, "export", file, "--to", "px4", "--out", tmp_path / "out", "--flights", "2"
    )
    told = " ".join(told.split())
    assert code == 0 and "rounding alone" in told and "IMU_GYRO_CUTOFF = 40 Hz (the default)" in told
    document = json.loads((tmp_path / "out" / "export.json").read_text())
    assert {row["loop"] for row in document["verification"]["gyro_filter"]["rows"]} == {
        "x",
        "y",
        "z",
        "roll",
        "pitch",
        "yaw",
    }
