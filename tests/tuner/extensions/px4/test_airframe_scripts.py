"""Airframe scripts of PX4: settings of the present and of older releases, conditions, and files of other frames."""

import pytest

import tuner
from plant.errors import InputError
from tests.tuner.exchange.reading import read, write
from tests.tuner.extensions.autopilots.test_sources import FILES
from tests.tuner.extensions.judge.test_reading_once import without_flights
from tuner.extensions.autopilots.sources import guess_source, sources

__all__ = ["without_flights"]
# As ROMFS/px4fmu_common/init.d/airframes/4052_holybro_qav250 has it.
SCRIPT = """#!/bin/sh
#
# @name HolyBro QAV250
#
# @type Quadrotor x
# @class Copter
#

. ${R}etc/init.d/rc.mc_defaults

param set-default BAT_N_CELLS 4
param set-default MC_ROLLRATE_P 0.076
param set-default MC_ROLLRATE_I 0.3   # firm
param set-default IMU_GYRO_CUTOFF 120
param set-default IMU_GYRO_CUTOFF 90
set MIXER quad_x
"""
# As releases before 1.12 have it.
OLD = """#!/bin/sh
# @type Quadrotor x
if [ $AUTOCNF = yes ]
then
\tparam set MC_ROLLRATE_P 0.15000
\t#param set MC_ROLLRATE_I 0.90000
else
\tparam set MC_PITCHRATE_P 1.0
fi
if param compare SENS_EXT_MAG 1
then
\tparam set MC_YAWRATE_P 0.9
fi
if [ $X = 1 ]; then param set MC_YAW_P 9; fi
param set SITL_UDP_PRT '$PORT'
"""


def test_settings_are_parameters_and_the_last_one_counts(tmp_path):
    file = write(tmp_path, SCRIPT, "4052_holybro_qav250")
    assert guess_source(file) == "px4"
    values = sources()["px4"].values(file)
    assert values == pytest.approx(
        {"BAT_N_CELLS": 4, "MC_ROLLRATE_P": 0.076, "MC_ROLLRATE_I": 0.3, "IMU_GYRO_CUTOFF": 90}
    )


def test_notes_name_what_is_not_read(tmp_path):
    notes = "\n".join(read("px4", write(tmp_path, SCRIPT), airframe="f450").notes)
    assert "Read as an airframe script of PX4: it sets 4 parameters." in notes
    assert "Included by the script, and not read: rc.mc_defaults." in notes
    assert "the last value counts, as on the vehicle: IMU_GYRO_CUTOFF." in notes
    old = "\n".join(read("px4", write(tmp_path, OLD), airframe="f450").notes)
    assert (
        "if param compare SENS_EXT_MAG 1, if [ $X = 1 ]; then param set MC_YAW_P 9; fi, SITL_UDP_PRT = '$PORT'." in old
    )


def test_of_conditions_that_of_a_new_vehicle_alone_counts(tmp_path):
    assert sources()["px4"].values(write(tmp_path, OLD)) == pytest.approx({"MC_ROLLRATE_P": 0.15})


def test_a_script_is_judged_over_a_parameter_file(tmp_path, without_flights):
    script, file = write(tmp_path, SCRIPT, "script"), write(tmp_path, FILES["px4"], "vehicle.params")
    for pair in ((script,), (script, file), (file, script)):
        with pytest.raises(InputError, match="the flights were reached"):
            tuner.judge(*pair)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (SCRIPT.replace("Quadrotor x", "Hexarotor x"), "@type: given Hexarotor x; only files of quadrotors"),
        (SCRIPT + "param set-default CA_ROTOR_COUNT 8\n", "CA_ROTOR_COUNT: given 8, an octocopter"),
        ("#!/bin/sh\nif [ $X = 1 ]\nthen\nparam set MC_ROLL_P 7\nfi\n", "holds no parameter"),
        ("param set MC_ROLL_P 1e99\n", "MC_ROLL_P: given"),
    ],
)
def test_a_script_of_no_quadrotor_is_refused(text, words, tmp_path):
    with pytest.raises(InputError, match=words):
        sources()["px4"].values(write(tmp_path, text))
