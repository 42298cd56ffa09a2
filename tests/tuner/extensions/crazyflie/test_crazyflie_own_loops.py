"""The Crazyflie's own loops as parameters: cflib reads the gains themselves, and the firmware's cascade answers as our law does."""

from dataclasses import replace
from math import degrees

import numpy as np
import pytest

from objectives.margins.margins import MarginModel
from objectives.margins.trim import Trim
from plant.errors import InputError
from plant.law_registry import LAWS, law
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.loop import Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.gains import default_row, gain_addresses
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.rigid_body import rotor_torque
from plant.records import pack
from plant.vectors import Rotors, Vec3
from tests.clients import ask
from tests.objectives.margins.test_margin_autopilots import LAG, expected_loop
from tests.tuner.exchange.flying_autopilots import by_address
from tests.tuner.extensions.crazyflie.test_crazyflie_parameters import READ, FirmwarePid, legacy_mixing, request
from tuner.extensions.crazyflie.export import FILE, TARGET
from tuner.extensions.crazyflie.map import TABLE
from tuner.gains import Controller

AXES = ("roll", "pitch", "yaw")
H = 0.002
# A gain of each kind away from the firmware's default.
TUNED = {
    "roll.p": 310.0,
    "roll.i": 420.0,
    "pitch.d": 3.3,
    "yaw.ff": 12.0,
    "roll.angle_p": 7.7,
    "pitch.angle_i": 1.3,
    "yaw.angle_d": 0.2,
    "pitch.angle_d": 0.01,
}


def own(airframe="crazyflie-pybullet", changed=None, **changes):
    frame = changed or load(airframe, allow_unphysical=True)
    cascade = close_cascade(law("pid"), law("crazyflie"), 5)
    row = default_row(cascade, frame.vehicle)
    chosen = {**TUNED, **{name.replace("__", "."): value for name, value in changes.items()}}
    for gain in gain_addresses(cascade):
        row[gain.column] = chosen.get(gain.address, row[gain.column])
    return Controller(frame, cascade, ControlOptions(), H, H, tuple(row))


def written(given, **settings):
    return {parameter.name: parameter.held for parameter in TARGET.export(request(given, **settings)).parameters}


def test_cflib_reads_the_gains_themselves(tmp_path):
    file = tmp_path / FILE
    file.write_bytes(TARGET.export(request(own())).files[FILE])
    found = {name: value for name, (_, _, value) in ask("crazyflie", READ, str(file)).items()}
    expected = {
        "pid_rate.roll_kp": 310.0,
        "pid_rate.roll_ki": 420.0,
        "pid_rate.pitch_kd": 3.3,
        "pid_rate.yaw_kff": 12.0,
        "pid_rate.yaw_ki": 16.7,
        "pid_attitude.roll_kp": 7.7,
        "pid_attitude.pitch_ki": 1.3,
        "pid_attitude.yaw_kd": 0.2,
        "pid_attitude.roll_kff": 0.0,
        "pid_rate.rateFiltEn": 0,
        "posCtlPid.zKi": 0.0,
    }
    assert {name: found[name] for name in expected} == pytest.approx(expected, rel=1e-7)
    assert set(found) <= set(TABLE)


def turned(vehicle, counts, axis, full):
    """Angular acceleration [rad/s2] that counts of an axis' output give through the firmware's mixing, in our axes."""
    command = [0.0, 0.0, 0.0]
    command[axis] = -counts if axis == 2 else counts
    thrusts = Rotors(*[count * full / 65535.0 for count in legacy_mixing(30000.0, *command)])
    torque = rotor_torque(thrusts, vehicle.rotor_x, vehicle.rotor_y, vehicle.spin, vehicle.torque_ratio)
    return torque[axis] / vehicle.inertia[axis]


@pytest.mark.parametrize(("airframe", "full"), [("crazyflie-pybullet", "airframe"), ("hummingbird-rotorpy", "5")])
@pytest.mark.parametrize("axis", range(3), ids=AXES)
def test_the_firmwares_loops_answer_as_ours(axis, airframe, full):
    """Sample by sample, from random angles, rates and angles asked for, through degrees, signs, counts and mixing.

    The firmware's angle loop hears angles alone: the rate of a reference changes nothing.
    """
    name = AXES[axis]
    given = own(airframe, roll__gyro_cutoff=0.0, pitch__gyro_cutoff=0.0, yaw__gyro_cutoff=0.0)
    values, vehicle = written(given, full_thrust=full), given.airframe.vehicle
    most = vehicle.thrust_coefficient * vehicle.speed_max**2 if full == "airframe" else float(full)
    gains = getattr(pack(given.cascade.Gains, given.gains), name)._replace(i_limit=1e9)
    ours, sign = LAWS["crazyflie"], -1.0 if name == "pitch" else 1.0
    outer = FirmwarePid(values, [f"pid_attitude.{name}_{term}" for term in ("kp", "ki", "kd")], H)
    inner = FirmwarePid(values, [f"pid_rate.{name}_{term}" for term in ("kp", "ki", "kd")], H)
    constants = ours.prepare(gains, H)
    memory = ours.start(constants, Measured(0.0, 0.0), 0.0)
    rng = np.random.default_rng(axis)
    expected, found = np.zeros((2, 300))
    for k, (angle, rate, asked) in enumerate(np.cumsum(rng.normal(0.0, [1e-4, 1e-3, 1e-4], (300, 3)), axis=0).tolist()):
        seen, goal = Measured(angle, rate), Setpoint(asked, 0.7, 0.0)
        found[k], memory = ours.step(memory, constants, Channel(1.0, 0.0), goal, seen, Applied(0.0, 0.0), H)
        place, turning = sign * degrees(angle), sign * degrees(rate)
        wanted = outer.update(sign * degrees(asked) - place, place)
        counts = inner.update(wanted - turning, turning) + values[f"pid_rate.{name}_kff"] * wanted
        expected[k] = turned(vehicle, counts, axis, most)
    assert found == pytest.approx(expected, rel=1e-5, abs=1e-6 * np.abs(expected).max(axis=0))


@pytest.mark.parametrize("d_cutoff", [45.0, 110.0])
def test_margins_of_what_the_vehicle_holds_are_those_of_the_file(d_cutoff):
    """An independent loop transfer function of the numbers in the file, with the authority that the mixing has."""
    frame, none = load("hummingbird-rotorpy", allow_unphysical=True), Vec3(0.0, 0.0, 0.0)
    vehicle = frame.vehicle._replace(
        drag_linear=none,
        drag_quadratic=none,
        rate_damping=none,
        drag_height=0.0,
        lag_up=LAG,
        lag_down=LAG,
        rotor_inertia=0.0,
    )
    frame = replace(frame, vehicle=vehicle)
    given = own(changed=frame, roll__d_cutoff=d_cutoff, pitch__d_cutoff=d_cutoff, yaw__d_cutoff=d_cutoff)
    bundle = TARGET.export(request(given))
    values, held = {one.name: one.held for one in bundle.parameters}, bundle.held
    model = MarginModel(held.cascade, nominal(vehicle, held.options, H), Timing(H, H), vehicle, Trim(hold=False))
    found = model.evaluate(np.array(held.gains)[None])
    gains = {
        **{f"angle_{term}": values[f"pid_attitude.roll_k{term}"] for term in "pid"},
        **{term: values[f"pid_rate.roll_k{term}"] for term in ("p", "i", "d", "ff")},
        "d_cutoff": values["pid_rate.omxFiltCut"],
        "gyro_cutoff": 80.0,
        "authority": turned(vehicle, 1.0, 0, vehicle.thrust_coefficient * vehicle.speed_max**2),
    }
    w = np.array([found.crossover.value[0, 3]])
    there = expected_loop("crazyflie", gains, w, H)
    assert found.stable[0, 3] and abs(there[0]) == pytest.approx(1.0, abs=1e-6)
    assert found.phase.value[0, 3] == pytest.approx(abs(np.angle(-there[0])), abs=1e-6)


def test_one_switch_filters_d_of_all_axes():
    assert written(own(roll__d_cutoff=40.0, pitch__d_cutoff=40.0, yaw__d_cutoff=40.0))["pid_rate.omyFiltCut"] == 40.0
    with pytest.raises(InputError, match="pid_rate.rateFiltEn switches the filter of all three axes"):
        written(own(roll__d_cutoff=40.0))


def test_what_is_held_is_what_was_asked_to_float32():
    bundle = TARGET.export(request(own()))
    held, asked = by_address(bundle.held), by_address(own())
    carried = [name for name in asked if not name.endswith(".t_f")]
    assert {name: held[name] for name in carried} == pytest.approx({name: asked[name] for name in carried}, rel=1e-7)
    assert bundle.held.cascade.position_every == 5
