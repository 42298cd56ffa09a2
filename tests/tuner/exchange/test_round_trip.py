"""A vehicle's own file imported and exported with nothing tuned: what our loops carry comes back, everything else stays.

The file that an export writes is laid over the vehicle's own, as a ground station does that loads it.
"""

import json
from dataclasses import replace

import numpy as np
import pytest

from plant.quadrotor.gains import gain_addresses
from tests.tuner.exchange.reading import DIGEST, read, write
from tests.tuner.exchange.vehicle_files import ardupilot_files, crazyflie_files, px4_files
from tests.tuner.extensions.ardupilot.test_ardupilot import values_of as ardupilot_values
from tests.tuner.extensions.px4.test_px4 import values_of
from tuner.exchange.registry import exporter, settings_of
from tuner.exchange.run import bundle_of
from tuner.exchange.target import Request
from tuner.extensions.ardupilot import export as ardupilot
from tuner.extensions.crazyflie import export as crazyflie
from tuner.extensions.crazyflie import text as cflib_file
from tuner.extensions.px4 import export as px4
from tuner.gains import read_gains, to_document

# What our PID carries, typed from the form that docs/exports.md gives: outer P, inner P and I of every loop, and the tilt.
PX4_CARRIED = {
    *(f"MC_{axis}_P" for axis in ("ROLL", "PITCH", "YAW")),
    *(f"MC_{axis}RATE_{term}" for axis in ("ROLL", "PITCH", "YAW") for term in "PI"),
    "MPC_XY_P", "MPC_XY_VEL_P_ACC", "MPC_XY_VEL_I_ACC", "MPC_Z_P", "MPC_Z_VEL_P_ACC", "MPC_Z_VEL_I_ACC", "MPC_TILTMAX_AIR",
    "MC_YAW_TQ_CUTOFF",
}  # fmt: skip


# The same of ArduPilot, in both dialects; the P gain on the vertical acceleration is none of ours.
ARDUPILOT_CARRIED = {
    *(f"ATC_ANG_{axis}_P" for axis in ("RLL", "PIT", "YAW")),
    *(f"ATC_RAT_{axis}_{term}" for axis in ("RLL", "PIT", "YAW") for term in "PI"),
    "PSC_POSXY_P", "PSC_VELXY_P", "PSC_VELXY_I", "PSC_POSZ_P", "PSC_VELZ_P", "PSC_ACCZ_I", "PSC_NE_POS_P", "PSC_NE_VEL_P",
    "PSC_NE_VEL_I", "PSC_D_POS_P", "PSC_D_VEL_P", "PSC_D_ACC_I", "PSC_ANGLE_MAX", "ATC_RAT_YAW_FLTE",
}  # fmt: skip


def px4_values(content):
    """What a vehicle holds that has loaded a file."""
    return held_values(values_of(content))


def held_values(values):
    """Numbers as float32."""
    return {name: float(np.float32(value)) for name, value in values.items()}


# What PX4's own loops carry besides: all that acts in them but K and the feed of thrust.
PX4_OWN = PX4_CARRIED | {
    *(f"MC_{axis}RATE_{term}" for axis in ("ROLL", "PITCH", "YAW") for term in ("D", "FF")),
    "MC_RR_INT_LIM",
    "MC_PR_INT_LIM",
    "MC_YR_INT_LIM",
    "MPC_XY_VEL_D_ACC",
    "MPC_Z_VEL_D_ACC",
    "IMU_GYRO_CUTOFF",
    "IMU_DGYRO_CUTOFF",
    "IMU_GYRO_NF0_FRQ",
    "IMU_GYRO_NF0_BW",
    "MPC_VELD_LP",
}


def imported(source, case, folder, *settings):
    """Import a file through gains.json, as the command line does."""
    found = read(source, write(folder, case.text, f"{case.name}.params"), *settings, *case.settings, airframe="iris")
    file = folder / "vehicle.json"
    file.write_text(json.dumps(to_document(found.controller, {})))
    return found, read_gains(file)


def exported(target, controller, *given, previous=None):
    """Export with the options of the import, as `tuner export` does."""
    from tuner.exchange.aboard import remembered

    entry = exporter(target)
    settings = settings_of(entry, remembered(controller, entry, list(given)))
    return bundle_of(entry, Request(controller, DIGEST, settings, previous))


def check_untouched(case, found, made, written, carried):
    """Nothing was tuned, so the vehicle is what it was, to float32, and what our loops cannot carry has been named."""
    for name, value in written.items():
        if name in case.values:
            own = float(np.float32(case.values[name]))
            slack = np.spacing(np.float32(abs(own))) if name in carried else 0.0
            assert abs(value - own) <= slack, (name, own, value)
        else:
            assert name in carried, name
    notes, losses = "\n".join(found.notes), "\n".join(made.differences)
    record = found.controller.vehicle
    for name in case.values:
        if name in carried:
            assert name in written
        elif name in case.others:
            assert name in found.untouched and name not in written and name not in record.parameters
        else:
            assert name in record.untuned and f"{name} = {case.values[name]:g}" in notes, name
            assert name not in written or f"{name} = {case.values[name]:g}" in losses, name
    assert {one.name for one in made.parameters if one.before is not None} == set(written) & set(case.values)


@pytest.mark.parametrize("case", px4_files(), ids=lambda case: case.name)
def test_a_px4_vehicle_is_what_it_was(case, tmp_path):
    found, controller = imported("px4", case, tmp_path)
    assert controller.gains == found.controller.gains
    made = exported("px4", controller)
    check_untouched(case, found, made, px4_values(made.files[px4.FILE]), PX4_CARRIED)
    assert made.held.gains == pytest.approx(controller.gains, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("case", px4_files(), ids=lambda case: case.name)
def test_a_px4_vehicle_in_its_own_loops_is_what_it_was(case, tmp_path):
    """Every gain is a parameter: no form that a file might not have, and nothing but scales and weights left beside."""
    found, controller = imported("px4", case, tmp_path, "loops=own")
    assert controller.gains == found.controller.gains and controller.cascade.position_every == 8
    made = exported("px4", controller)
    written = px4_values(made.files[px4.FILE])
    check_untouched(case, found, made, written, PX4_OWN)
    assert made.held.gains == pytest.approx(controller.gains, rel=1e-7, abs=1e-12)
    assert made.gyro is None
    for name in PX4_OWN & set(case.values) - {"MPC_TILTMAX_AIR", "MC_YAW_TQ_CUTOFF"}:
        assert written[name] == float(np.float32(case.values[name])), name


# ArduPilot's own rate loops carry besides: all that acts in them but the derivative of the target and the slew limit.
ARDUPILOT_OWN = (
    ARDUPILOT_CARRIED
    | {"INS_GYRO_FILTER"}
    | {
        f"ATC_RAT_{axis}_{term}"
        for axis in ("RLL", "PIT", "YAW")
        for term in ("D", "FF", "IMAX", "FLTT", "FLTE", "FLTD")
    }
)


@pytest.mark.parametrize("case", ardupilot_files(), ids=lambda case: case.name)
def test_an_ardupilot_vehicle_in_its_own_loops_is_what_it_was(case, tmp_path):
    found, controller = imported("ardupilot", case, tmp_path, "loops=own", "control_period=0.001")
    made = exported("ardupilot", controller)
    written = held_values(ardupilot_values(made.files[ardupilot.FILE]))
    check_untouched(case, found, made, written, ARDUPILOT_OWN)
    for name in (ARDUPILOT_OWN - ARDUPILOT_CARRIED) & set(case.values):
        assert written[name] == float(np.float32(case.values[name])), name
    assert made.gyro is None and made.held.options.yaw_torque_cutoff == 0.0


@pytest.mark.parametrize("case", ardupilot_files(), ids=lambda case: case.name)
def test_an_ardupilot_vehicle_is_what_it_was(case, tmp_path):
    """The firmware, the rotors' curve and what counts as inertia come with the import; Copter 3.x under its new names."""
    found, controller = imported("ardupilot", case, tmp_path)
    made = exported("ardupilot", controller)
    written = held_values(ardupilot_values(made.files[ardupilot.FILE]))
    check_untouched(case, found, made, written, ARDUPILOT_CARRIED)
    assert made.held.gains == pytest.approx(controller.gains, rel=1e-6, abs=1e-12)


# What the Crazyflie's own loops carry: all but feed-forward of angles and positions, D of velocities and I of positions.
CRAZYFLIE_CARRIED = {
    *(f"pid_rate.{axis}_{term}" for axis in ("roll", "pitch", "yaw") for term in ("kp", "ki", "kd", "kff")),
    *(f"pid_attitude.{axis}_{term}" for axis in ("roll", "pitch", "yaw") for term in ("kp", "ki", "kd")),
    *(f"velCtlPid.v{axis}{term}" for axis in "xyz" for term in ("Kp", "Ki")), *(f"posCtlPid.{axis}Kp" for axis in "xyz"),
    "posCtlPid.rLimit", "posCtlPid.pLimit", "pid_rate.rateFiltEn", *(f"pid_rate.om{axis}FiltCut" for axis in "xyz"),
}  # fmt: skip


@pytest.mark.parametrize("case", crazyflie_files(), ids=lambda case: case.name)
def test_a_crazyflie_is_what_it_was(case, tmp_path):
    found, controller = imported("crazyflie", case, tmp_path)
    assert controller.gains == found.controller.gains and controller.cascade.position_every == 5
    made = exported("crazyflie", controller)
    values = held_values(cflib_file.read(write(tmp_path, made.files[crazyflie.FILE], "back.yaml")))
    check_untouched(case, found, made, values, CRAZYFLIE_CARRIED)
    plain = [name for name in CRAZYFLIE_CARRIED & set(case.values) if name.startswith("pid_")]
    assert {name: values[name] for name in plain} == {name: float(np.float32(case.values[name])) for name in plain}
    assert made.held.gains == pytest.approx(
        [
            0.0 if gain.info.name == "t_f" else controller.gains[gain.column]
            for gain in gain_addresses(controller.cascade)
        ],
        rel=1e-6,
        abs=1e-12,
    )


def test_there_are_twenty_files_of_each():
    for files in (px4_files(), ardupilot_files(), crazyflie_files()):
        assert len(files) == len({case.text for case in files}) == 20


def test_gains_imported_from_4_6_export_for_4_7(tmp_path):
    """Everything under its new name and in its new unit, as the parameter's description of 4.7 tells."""
    case = ardupilot_files()[0]
    _, controller = imported("ardupilot", case, tmp_path)
    made = exported("ardupilot", controller, "firmware=4.7")
    values = held_values(ardupilot_values(made.files[ardupilot.FILE]))
    assert values["PSC_D_ACC_P"] == pytest.approx(0.05) and values["PSC_D_ACC_I"] == pytest.approx(0.1)
    assert (values["PSC_D_VEL_P"], values["PSC_D_POS_P"]) == pytest.approx((5.0, 1.0))
    assert values["PSC_ANGLE_MAX"] == 0.0 and values["ATC_RAT_RLL_D"] == pytest.approx(0.0036)
    assert "PSC_ACCZ_P" not in values


def tuned(controller, **changes):
    """The same controller with gains multiplied, written roll__kp=1.1."""
    from plant.quadrotor.gains import gain_addresses

    row = list(controller.gains)
    for gain in gain_addresses(controller.cascade):
        row[gain.column] *= changes.get(gain.address.replace(".", "__"), 1.0)
    return replace(controller, gains=tuple(row))


def test_a_tuned_axis_changes_and_no_other(tmp_path):
    """K, thrust model, D and hover thrust stay; P follows kd with K in it."""
    case = px4_files()[7]
    _, controller = imported("px4", case, tmp_path)
    values = px4_values(exported("px4", tuned(controller, roll__kp=1.1, roll__ki=1.1, roll__kd=1.1)).files[px4.FILE])
    changed = {name for name, value in values.items() if value != case.values.get(name)}
    assert changed == {"MC_ROLLRATE_P", "MC_ROLLRATE_I"}
    for name in changed:
        assert values[name] == pytest.approx(1.1 * case.values[name], rel=1e-6)


def test_the_split_stays_the_vehicles_when_gains_change_a_little(tmp_path):
    """Angle loop 4 1/s around an integral of 10 1/s: a root of the same quadratic as 10 1/s around 4 1/s."""
    case = next(case for case in px4_files() if case.name == "typed-3")
    _, controller = imported("px4", case, tmp_path)
    values = px4_values(exported("px4", tuned(controller, roll__kp=1.01)).files[px4.FILE])
    assert values["MC_ROLL_P"] == pytest.approx(4.0, rel=0.05)


def test_the_previous_file_counts_more_than_the_import(tmp_path):
    case = next(case for case in px4_files() if case.name == "typed-0")
    _, controller = imported("px4", case, tmp_path)
    now = write(tmp_path, case.text.replace("THR_MDL_FAC\t0.3", "THR_MDL_FAC\t0.2"), "now.params")
    made = exported("px4", controller, previous=now)
    values = px4_values(made.files[px4.FILE])
    assert values["THR_MDL_FAC"] == float(np.float32(0.2)) and values["MC_ROLLRATE_P"] != 0.15
    assert any("now.params" in sentence for sentence in made.differences)


def test_others_can_be_switched_off(tmp_path):
    case = next(case for case in px4_files() if case.name == "typed-1")
    _, controller = imported("px4", case, tmp_path)
    made = exported("px4", controller, "others=off")
    values = px4_values(made.files[px4.FILE])
    assert (values["MC_ROLLRATE_D"], values["THR_MDL_FAC"], values["MC_YAW_WEIGHT"]) == (0.0, 1.0, 1.0)
    rows = {one.name: one for one in made.parameters}
    assert rows["MC_ROLLRATE_D"].before == pytest.approx(0.0012) and not rows["MC_ROLLRATE_D"].is_unmanaged
