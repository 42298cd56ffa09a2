"""Crazyflie parameters: cflib reads them back, and the firmware's cascade, written here from its rules, acts as our PID does."""

import json
from dataclasses import replace
from math import cos, degrees, pi, radians, sin

import numpy as np
import pytest

from plant.errors import InputError
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.nominal import ControlOptions
from plant.quadrotor.rigid_body import rotor_torque
from plant.records import pack
from plant.vectors import Rotors
from tests.clients import ask
from tests.tuner.exchange.controllers import controller, pid
from tuner.exchange.run import check_laws
from tuner.exchange.target import Request
from tuner.extensions.crazyflie import text as param_file
from tuner.extensions.crazyflie.export import FILE, TARGET
from tuner.extensions.crazyflie.map import ENTRIES, GYRO_FILTER, INTEGERS, torque_per_count

READ = """
import json, sys
from cflib.localization.param_io import ParamFileManager
try:
    found = ParamFileManager.read(sys.argv[1])
    print(json.dumps({name: [state.is_stored, state.default_value, state.stored_value] for name, state in found.items()}))
except Exception as error:
    print(json.dumps({"error": str(error)}))
"""
WRITE = """
import json, sys
from cflib.crazyflie.param import PersistentParamState
from cflib.localization.param_io import ParamFileManager
values = {"pid_rate.roll_kp": PersistentParamState(True, 250.0, 312.5), "posCtlPid.thrustBase": PersistentParamState(True, 36000, 37000),
          "pid_rate.roll_ki": PersistentParamState(False, 500.0, None), "velCtlPid.vxKi": PersistentParamState(True, 1.0, 1e-5)}
ParamFileManager.write(sys.argv[1], values)
print("{}")
"""


def request(given=None, previous=None, **settings):
    given = given or pid("crazyflie-pybullet")
    return Request(given, "f" * 64, {"form": "by-law", "full_thrust": "airframe"} | settings, previous)


def values(given=None, **settings):
    return {parameter.name: parameter.held for parameter in TARGET.export(request(given, **settings)).parameters}


def test_cflib_reads_what_the_vehicle_is_to_hold(tmp_path):
    bundle = TARGET.export(request())
    file = tmp_path / FILE
    file.write_bytes(bundle.files[FILE])
    found = ask("crazyflie", READ, str(file))
    assert set(found) == set(ENTRIES) == {parameter.name for parameter in bundle.parameters}
    for parameter in bundle.parameters:
        stored, usual, value = found[parameter.name]
        assert stored is True
        whole = parameter.name in INTEGERS
        assert type(value) is type(usual) is (int if whole else float), parameter.name
        # float32 on the vehicle
        assert np.float32(value) == np.float32(parameter.held) and np.float32(usual) == np.float32(parameter.usual)
        assert abs(parameter.held - parameter.unrounded) <= (0.5 if whole else 6e-8 * abs(parameter.unrounded))


def test_cflib_refuses_an_unquoted_version(tmp_path):
    file = tmp_path / FILE
    file.write_bytes(TARGET.export(request()).files[FILE].replace(b"version: '1'", b"version: 1"))
    assert "version" in ask("crazyflie", READ, str(file))["error"]


def test_a_count_is_what_the_firmwares_header_says():
    """For its own arm of 46 mm and 0.12 N: 1.19e-7 N m per roll count; the default of 250 is then 1.7e-3 N m s/rad."""
    vehicle = load("crazyflie-pybullet").vehicle
    lever = 0.0325
    square = vehicle._replace(
        rotor_x=Rotors(lever, lever, -lever, -lever), rotor_y=Rotors(lever, -lever, lever, -lever)
    )
    count = torque_per_count(actuation(square), 0.12)
    assert count.roll == count.pitch == pytest.approx(1.19e-7, rel=2e-3)
    assert count.yaw == pytest.approx(4 * 0.02513 * 0.12 / 65535)
    assert 250.0 * count.roll * degrees(1.0) == pytest.approx(1.7e-3, rel=0.01)


class FirmwarePid:
    """pid.c: the integral takes effect in the period it is formed in."""

    def __init__(self, written, names, dt):
        self.kp, self.ki, self.kd = (written[name] for name in names)
        self.dt, self.sum, self.last = dt, 0.0, 0.0

    def update(self, error, measured):
        rate = -(measured - self.last) / self.dt
        self.sum += error * self.dt
        self.last = measured
        return self.kp * error + self.kd * rate + self.ki * self.sum


def legacy_mixing(thrust, roll, pitch, yaw):
    """Counts of the motors 1 front right, 2 rear right, 3 rear left, 4 front left, in our order."""
    r, p = roll / 2.0, pitch / 2.0
    m1, m2, m3, m4 = thrust - r + p + yaw, thrust - r - p - yaw, thrust + r - p + yaw, thrust + r + p - yaw
    return m4, m1, m3, m2


@pytest.mark.parametrize("airframe", ["hummingbird-rotorpy", "iris"])
@pytest.mark.parametrize("axis", ["roll", "pitch", "yaw"])
def test_the_firmwares_cascade_turns_the_vehicle_as_our_pid_does(axis, airframe):
    """From angles and rates of ours, through its degrees, signs, counts and mixing, to torques on our rotors. At 10 us the loops are
    continuous to 1e-4, so which period an integral acts in does not show.
    """
    given = pid(airframe, pitch__kp=80.0)
    written = values(given)
    gains = getattr(pack(given.cascade.Gains, given.gains), axis)
    vehicle, dt = given.airframe.vehicle, 1e-5
    full = vehicle.thrust_coefficient * vehicle.speed_max**2
    outer = FirmwarePid(written, [f"pid_attitude.{axis}_{name}" for name in ("kp", "ki", "kd")], dt)
    inner = FirmwarePid(written, [f"pid_rate.{axis}_{name}" for name in ("kp", "ki", "kd")], dt)
    sign = -1.0 if axis == "pitch" else 1.0
    index = ("roll", "pitch", "yaw").index(axis)
    inertia, integral, angle, rate, output = vehicle.inertia[index], 0.0, 0.0, 0.0, 0.0
    for k in range(30000):
        angle, rate = 0.2 * sin(6.0 * dt * k), 1.2 * cos(6.0 * dt * k)
        integral += angle * dt
        legacy_angle, legacy_rate = sign * degrees(angle), sign * degrees(rate)
        wanted = outer.update(0.0 - legacy_angle, legacy_angle)
        output = inner.update(wanted - legacy_rate, legacy_rate)
    command = [0.0, 0.0, 0.0]
    command[index] = -output if axis == "yaw" else output
    counts = legacy_mixing(written["posCtlPid.thrustBase"], *command)
    thrusts = Rotors(*[count * full / 65535.0 for count in counts])
    torque = rotor_torque(thrusts, vehicle.rotor_x, vehicle.rotor_y, vehicle.spin, vehicle.torque_ratio)
    ours = -inertia * (gains.kp * angle + gains.ki * integral + gains.kd * rate)
    assert torque[index] == pytest.approx(ours, rel=5e-4)
    assert [torque[i] for i in range(3) if i != index] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert abs(gains.ki * integral) > 0.02 * abs(gains.kp * angle)  # the integral has a say


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_the_firmwares_position_loops_accelerate_as_our_pid_does(axis):
    given = pid("crazyflie-pybullet", y__kp=2.6, z__kd=2.7)
    written = values(given)
    gains = getattr(pack(given.cascade.Gains, given.gains), axis)
    vehicle, dt = given.airframe.vehicle, 1e-4
    full = vehicle.thrust_coefficient * vehicle.speed_max**2
    outer = FirmwarePid(written, [f"posCtlPid.{axis}{name}" for name in ("Kp", "Ki", "Kd")], dt)
    inner = FirmwarePid(written, [f"velCtlPid.v{axis}{name}" for name in ("Kp", "Ki", "Kd")], dt)
    integral = place = speed = output = 0.0
    for k in range(20000):
        place, speed = 0.1 * sin(1.5 * dt * k), 0.15 * cos(1.5 * dt * k)
        integral += place * dt
        output = inner.update(outer.update(-place, place) - speed, speed)
    if axis == "z":
        thrust = (1000.0 * output + written["posCtlPid.thrustBase"]) * 4.0 * full / 65535.0
        acceleration = thrust / vehicle.mass - vehicle.gravity
        room = 0.5 * 4.0 * full / 65535.0 / vehicle.mass  # thrustBase is a whole number
    else:
        acceleration, room = vehicle.gravity * radians(output), 0.0
    ours = -(gains.kp * place + gains.ki * integral + gains.kd * speed)
    assert acceleration == pytest.approx(ours, rel=5e-4, abs=room)


def test_what_the_firmware_has_of_its_own_is_switched_off():
    """Its defaults of attitude ki and of rate kd are not 0; what is not written stays."""
    written = values()
    kept = {name for name, value in written.items() if value != 0.0}
    assert kept == {
        *(f"pid_rate.{axis}_{name}" for axis in ("roll", "pitch", "yaw") for name in ("kp", "ki")),
        *(f"pid_attitude.{axis}_kp" for axis in ("roll", "pitch", "yaw")),
        *(f"velCtlPid.v{axis}{name}" for axis in "xyz" for name in ("Kp", "Ki")),
        *(f"posCtlPid.{axis}Kp" for axis in "xyz"),
        "posCtlPid.rLimit",
        "posCtlPid.pLimit",
        "posCtlPid.thrustBase",
        "posCtlPid.thrustMin",
    }


def test_limits_and_hover():
    given = replace(pid("crazyflie-pybullet"), options=ControlOptions(tilt_limit=0.35))
    written = values(given, full_thrust="0.1125")
    hover = 0.027 * 9.81 / (4 * 0.1125) * 65535
    assert written["posCtlPid.thrustBase"] == round(hover)
    assert written["posCtlPid.thrustMin"] == round(0.2 * hover)
    assert written["posCtlPid.rLimit"] == written["posCtlPid.pLimit"] == pytest.approx(degrees(0.35))
    # Twice the thrust a count, half the counts.
    twice = values(given, full_thrust="0.225")
    assert twice["pid_rate.roll_kp"] == pytest.approx(0.5 * written["pid_rate.roll_kp"], rel=1e-6)
    assert twice["velCtlPid.vzKp"] == pytest.approx(0.5 * written["velCtlPid.vzKp"], rel=1e-6)
    assert twice["velCtlPid.vxKp"] == written["velCtlPid.vxKp"]


def test_held_is_ours_to_float32_with_the_firmwares_filter():
    given = pid("crazyflie-pybullet")
    bundle = TARGET.export(request(given))
    for axis in ("x", "y", "z", "roll", "pitch", "yaw"):
        mine, its = (getattr(pack(given.cascade.Gains, c.gains), axis) for c in (given, bundle.held))
        assert its[:3] == pytest.approx(mine[:3], rel=3e-7)
        assert its.t_f == (0.0 if axis in "xyz" else GYRO_FILTER)
    assert bundle.held.options.tilt_limit == pytest.approx(given.options.tilt_limit, rel=1e-7)
    # A Butterworth filter of second order delays slow signals by sqrt 2 / (2 pi f).
    frequency = 1.0
    s = 1j * frequency / 80.0
    assert GYRO_FILTER == pytest.approx(-np.angle(1 / (s * s + 2**0.5 * s + 1)) / (2 * pi * frequency), rel=1e-3)


def test_the_rollback_restores_defaults_or_what_was_stored(tmp_path):
    known = param_file.read(written_to(tmp_path / "default.yaml", TARGET.export(request()).rollback[FILE]))
    assert known == {name: pytest.approx(entry.usual, rel=1e-7) for name, entry in ENTRIES.items()}
    before = tmp_path / "before.yaml"
    ask("crazyflie", WRITE, str(before))
    back = TARGET.export(request(previous=before)).rollback[FILE]
    stored = param_file.read(written_to(tmp_path / "back.yaml", back))
    assert stored["pid_rate.roll_kp"] == 312.5 and stored["posCtlPid.thrustBase"] == 37000
    assert stored["pid_rate.roll_ki"] == 500.0 and stored["velCtlPid.vxKi"] == 1e-5
    found = ask("crazyflie", READ, str(tmp_path / "back.yaml"))
    assert found["pid_rate.roll_kp"][2] == 312.5 and found["velCtlPid.vxKi"][2] == 0.00001


def written_to(file, content):
    file.write_bytes(content)
    return file


HEAD = "type: persistent_param_state\nversion: '1'\nparams:\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("type: other\nversion: '1'\n", "type: must be persistent_param_state"),
        ("type: persistent_param_state\nversion: 1\n", "version: must be '1', in quotes"),
        (HEAD + "  a.b: {is_stored: true, default_value: 1.0, stored_value: x}\n", "a.b: given 'x'"),
        (HEAD + "  a.b: {is_stored: true, default_value: 1.0}\n", "a.b: given ''"),
        (HEAD + "  - 1\n", "is no parameter"),
    ],
)
def test_a_previous_file_that_is_wrong_is_named(tmp_path, text, words):
    with pytest.raises(InputError, match=words):
        TARGET.export(request(previous=written_to(tmp_path / "p.yaml", text.encode())))


def test_what_cannot_be_carried_is_refused_by_name():
    with pytest.raises(InputError, match="--set form: given 'parameters', but the laws are hybrid"):
        TARGET.export(request(controller("pid", "hybrid", "crazyflie-pybullet"), form="parameters"))
    with pytest.raises(InputError, match="--set full_thrust"):
        TARGET.export(request(full_thrust="0"))
    with pytest.raises(InputError, match="roll.ki: given 9999 s"):
        TARGET.export(request(pid("crazyflie-pybullet", roll__ki=9999.0)))
    with pytest.raises(InputError, match="pid_rate.roll_kp: .*change roll.kd"):
        TARGET.export(request(full_thrust="0.01", given=pid("hummingbird", roll__kd=1e4, roll__kp=1e6)))
    with pytest.raises(InputError, match="airframe"):
        TARGET.export(request(pid("hummingbird-rotors")))
    frame = load("crazyflie-pybullet")
    turned = replace(frame, vehicle=frame.vehicle._replace(spin=Rotors(-1.0, 1.0, 1.0, -1.0)))
    with pytest.raises(InputError, match=r"airframe\.spin"):
        TARGET.export(request(replace(pid("crazyflie-pybullet"), airframe=turned)))
    check_laws(TARGET, request())


def test_by_law_pid_gives_parameters_and_others_a_controller():
    assert set(TARGET.export(request()).files) == {FILE}
    period = replace(pid("crazyflie-pybullet"), control_period=0.002, plant_step=0.001)
    assert "src/Kbuild" in TARGET.export(request(period, form="controller")).files
    assert "src/Kbuild" in TARGET.export(request(controller("ladrc", "pid", "crazyflie-pybullet", 0.002))).files


def test_what_the_file_says_and_how_numbers_are_written():
    text = TARGET.export(request()).files[FILE].decode()
    for word in ("f" * 64, "crazyflie-pybullet", "position pid, attitude pid", "gainproof", "version: '1'"):
        assert word in text
    assert param_file.number("velCtlPid.vxKi", 8e-5) == "0.00008"
    assert param_file.number("pid_rate.roll_kp", 250.0) == "250.0"
    assert param_file.number("posCtlPid.thrustBase", 36000.0) == "36000"
    assert json.dumps(TARGET.export(request()).differences).count("500 Hz") == 1
