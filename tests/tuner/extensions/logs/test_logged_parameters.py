"""Parameters in flight logs: as files of gains for a judgement and an import, and damaged logs."""

from hashlib import sha256

import pytest

import tuner
from plant.errors import InputError
from tests.tuner.exchange.reading import read, write
from tests.tuner.extensions.autopilots.test_sources import FILES
from tests.tuner.extensions.judge.test_reading_once import without_flights
from tests.tuner.extensions.logs.parameter_logs import dataflash, ulog
from tuner.extensions.autopilots.sources import guess_source, sources

__all__ = ["without_flights"]
PX4 = {"MC_ROLLRATE_P": 0.125, "MC_PITCH_P": 7.5, "CA_ROTOR_COUNT": 4, "IMU_GYRO_RATEMAX": 800, "RTL_X": float("nan")}
COPTER = [("ATC_RAT_RLL_P", 0.125), ("ATC_ANG_PIT_P", 7.5), ("FRAME_CLASS", 1.0), ("ATC_RAT_RLL_P", 0.25)]
LOGS = {"px4": (ulog(PX4), "MC_ROLLRATE_P", "1.14"), "ardupilot": (dataflash(COPTER), "ATC_RAT_RLL_P", "4.5")}


@pytest.mark.parametrize("source", LOGS)
def test_a_log_is_a_parameter_file(source, tmp_path):
    content, gain, version = LOGS[source]
    file, kind = tmp_path / "flight.log", sources()[source]
    file.write_bytes(content)
    assert guess_source(file) == source and kind.version(file) == version
    values = kind.values(file)
    # The first of two values of a DataFlash log, and no NaN.
    assert values[gain] == 0.125 and set(values) == {
        name for name, value in (PX4 if source == "px4" else dict(COPTER)).items() if value == value
    }


def test_the_loop_rate_of_a_log_is_that_of_the_loops(tmp_path):
    file = tmp_path / "flight.ulg"
    file.write_bytes(ulog(PX4))
    assert sources()["px4"].options(file)["control_period"] == "0.00125"


@pytest.mark.parametrize("source", LOGS)
def test_an_import_from_a_log_is_that_of_the_file_with_its_parameters(source, tmp_path):
    content, gain, version = LOGS[source]
    log = tmp_path / "flight.log"
    log.write_bytes(content)
    other = "MC_PITCH_P" if source == "px4" else "ATC_ANG_PIT_P"
    lines = (
        [f"{gain},0.125", f"{other},7.5"]
        if source == "ardupilot"
        else [f"1\t1\t{gain}\t0.125\t9", f"1\t1\t{other}\t7.5\t9"]
    )
    options = ["firmware=4.6"] if source == "ardupilot" else []
    plain = read(source, write(tmp_path, "\n".join(lines) + "\n"), *options, airframe="f450")
    logged = read(source, log, *options, airframe="f450")
    assert logged.controller.gains == plain.controller.gains
    assert "parameters of a flight log, as they were when it began." in "\n".join(logged.notes)


def test_parameters_that_change_during_a_log_are_named(tmp_path):
    file = tmp_path / "flight.bin"
    file.write_bytes(dataflash(COPTER))
    notes = "\n".join(read("ardupilot", file, "firmware=4.6", airframe="f450").notes)
    assert "Changed during the log, and not read so: ATC_RAT_RLL_P 0.125 to 0.25." in notes


@pytest.mark.parametrize("source", LOGS)
def test_a_log_is_judged_before_and_after(source, tmp_path, without_flights):
    log, file = tmp_path / "flight.log", write(tmp_path, FILES[source], "vehicle.txt")
    log.write_bytes(ulog({"MC_ROLLRATE_P": 0.125}) if source == "px4" else dataflash([("ATC_RAT_RLL_P", 0.125)]))
    if source == "px4":
        file.write_text(file.read_text().replace("1.16.0", "1.14.3"))
    for pair in ((log, file), (file, log)):
        with pytest.raises(InputError, match="the flights were reached"):
            tuner.judge(*pair)


def test_the_rollback_of_a_log_is_a_parameter_file_and_its_digest_that_of_the_log(tmp_path):
    log, after = tmp_path / "flight.ulg", write(tmp_path, "1\t1\tSYS_X\t1\t6\n1\t1\tCA_Y\t1\t6\n", "after.params")
    log.write_bytes(ulog(PX4))
    opinion = tuner.judge(after, log, source="px4", out=tmp_path / "out")
    assert opinion.folder is not None and opinion.document.rollback is not None and opinion.document.before is not None
    assert b"1\t1\tMC_ROLLRATE_P\t0.125\t9\n" in (opinion.folder / opinion.document.rollback).read_bytes()
    assert opinion.document.before.sha256 == sha256(log.read_bytes()).hexdigest()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (ulog(PX4)[:7], "flight.log: is no ULog that can be read|flight.log: holds 0 parameters"),
        (ulog({}), "flight.log: holds 0 parameters"),
        (ulog({"mc_p": 1.0}), "holds the parameter 'mc_p'; it is damaged"),
        (ulog({**PX4, "CA_ROTOR_COUNT": 6}), "CA_ROTOR_COUNT: given 6, a hexacopter"),
        (ulog(PX4, name=b"ArduPilot"), "is a file of ArduPilot, not of PX4"),
        (dataflash([]), "flight.log: holds 0 parameters"),
        (dataflash([("A\x01B", 1.0)]), "holds the parameter"),
        (dataflash(COPTER, "ArduPlane V4.5.7"), "ArduPlane V4.5 is not supported|ArduPlane"),
        (dataflash(COPTER)[:89], "flight.log: holds 0 parameters"),
    ],
)
def test_a_log_without_the_parameters_of_a_quadrotor_is_refused(content, words, tmp_path):
    file = tmp_path / "flight.log"
    file.write_bytes(content)
    with pytest.raises(InputError, match=words) as caught:
        sources()[guess_source(file)].values(file)
    assert "\n" not in str(caught.value)
