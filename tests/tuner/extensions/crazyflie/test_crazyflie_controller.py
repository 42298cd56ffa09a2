"""The out-of-tree controller for the Crazyflie: compiled against headers with the firmware's fields, and flown beside the C99 code.

What the firmware would see is worked out here: its mixing (power_distribution_quadrotor.c, force and torque) from the published
rule of that file, its legacy angles from ours.
"""

import ctypes
import json
import math
import shutil
import subprocess

import numpy as np
import pytest

from plant.errors import InputError
from plant.law_registry import LAWS
from plant.quadrotor.nominal import ControlOptions
from tests.clients import program
from tests.tuner.exchange.controllers import controller
from tuner.exchange.target import Request
from tuner.extensions.crazyflie.export import TARGET
from tuner.gains import to_document

STRICT = ("-std=c11", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Werror")
ARM = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16")
SETTINGS = {"form": "by-law", "full_thrust": "airframe"}
# The fields of the firmware's types that a controller of ours reads and writes, in our own words.
TYPES = """
#pragma once
#include <stdbool.h>
#include <stdint.h>
typedef struct { float x, y, z; } Axis3f;
typedef struct { uint32_t timestamp; float roll, pitch, yaw; } attitude_t;
struct vec3_s { uint32_t timestamp; float x, y, z; };
typedef struct vec3_s point_t;
typedef struct vec3_s velocity_t;
typedef struct vec3_s acc_t;
typedef struct { uint32_t timestamp; float x, y, z, w; } quaternion_t;
typedef struct { Axis3f acc, gyro; } sensorData_t;
typedef struct { attitude_t attitude; quaternion_t attitudeQuaternion; point_t position; velocity_t velocity; acc_t acc; } state_t;
typedef enum { controlModeLegacy = 0, controlModeForceTorque = 1, controlModeForce = 2 } control_mode_t;
typedef struct { float thrustSi, torqueX, torqueY, torqueZ; control_mode_t controlMode; } control_t;
typedef enum { modeDisable = 0, modeAbs, modeVelocity } stab_mode_t;
typedef struct {
  attitude_t attitude, attitudeRate; quaternion_t attitudeQuaternion; float thrust;
  point_t position; velocity_t velocity; acc_t acceleration; bool velocity_body;
  struct { stab_mode_t x, y, z, roll, pitch, yaw, quat; } mode;
} setpoint_t;
typedef uint32_t stabilizerStep_t;
#define RATE_1000_HZ 1000
#define RATE_MAIN_LOOP RATE_1000_HZ
"""
STUBS = {
    "stabilizer_types.h": TYPES,
    "platform_defaults.h": "#pragma once\n#define ARM_LENGTH 0.046f\n#define THRUST2TORQUE 0.005964552f\n#define THRUST_MAX 0.1125f\n",
    "controller_pid.h": """#pragma once
#include "stabilizer_types.h"
void controllerPidInit(void);
void controllerPid(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors, const state_t *state,
                   const stabilizerStep_t stabilizerStep);
""",
    "app.h": "#pragma once\nvoid appMain(void);\n",
    "FreeRTOS.h": "#pragma once\n#define M2T(X) ((unsigned int)(X))\n",
    "task.h": "#pragma once\nvoid vTaskDelay(unsigned int ticks);\n",
}
ARM_LENGTH, THRUST2TORQUE = np.float32(0.046), np.float32(0.005964552)
# A plain-C face for Python: flat arrays in, flat arrays out.
FACE = """
#include "controller_gainproof.h"
#include "gainproof_controller.h"
static control_t control;
static gainproof_state beside;
void begin(void) { controllerOutOfTreeInit(); }
/* The firmware's own PID, of which only what it is asked counts here. */
static float asked[8];
void controllerPidInit(void) { asked[0] += 1.0f; }
void controllerPid(control_t *c, const setpoint_t *s, const sensorData_t *sensors, const state_t *state, const stabilizerStep_t step) {
  (void)sensors; (void)state; (void)step;
  asked[1] += 1.0f; asked[2] = s->thrust; asked[3] = (float)s->mode.roll; asked[4] = (float)s->mode.pitch;
  asked[5] = (float)s->mode.yaw; asked[6] = (float)s->mode.z; asked[7] = (float)c->controlMode;
  c->thrustSi = -1.0f;
}
void heard(float *out) { for (int i = 0; i < 8; i++) out[i] = asked[i]; }
/* s: position, velocity, quaternion wxyz, gyro deg/s. p: position, velocity, acceleration, attitude deg, attitudeRate deg/s,
   quaternion wxyz. mode: x y z roll pitch yaw quat body. out: mode thrust torques */
void fly(uint32_t tick, const float *s, const float *p, const int *mode, float *out) {
  state_t state = {0}; sensorData_t sensors = {0}; setpoint_t setpoint = {0};
  state.position.x = s[0]; state.position.y = s[1]; state.position.z = s[2];
  state.velocity.x = s[3]; state.velocity.y = s[4]; state.velocity.z = s[5];
  state.attitudeQuaternion.w = s[6]; state.attitudeQuaternion.x = s[7];
  state.attitudeQuaternion.y = s[8]; state.attitudeQuaternion.z = s[9];
  state.attitude.roll = state.attitude.pitch = state.attitude.yaw = s[6] - s[6]; /* finite where the quaternion is */
  sensors.gyro.x = s[10]; sensors.gyro.y = s[11]; sensors.gyro.z = s[12];
  setpoint.position.x = p[0]; setpoint.position.y = p[1]; setpoint.position.z = p[2];
  setpoint.velocity.x = p[3]; setpoint.velocity.y = p[4]; setpoint.velocity.z = p[5];
  setpoint.acceleration.x = p[6]; setpoint.acceleration.y = p[7]; setpoint.acceleration.z = p[8];
  setpoint.attitude.roll = p[9]; setpoint.attitude.pitch = p[10]; setpoint.attitude.yaw = p[11];
  setpoint.attitudeRate.roll = p[12]; setpoint.attitudeRate.pitch = p[13]; setpoint.attitudeRate.yaw = p[14];
  setpoint.attitudeQuaternion.w = p[15]; setpoint.attitudeQuaternion.x = p[16];
  setpoint.attitudeQuaternion.y = p[17]; setpoint.attitudeQuaternion.z = p[18];
  setpoint.mode.x = (stab_mode_t)mode[0]; setpoint.mode.y = (stab_mode_t)mode[1]; setpoint.mode.z = (stab_mode_t)mode[2];
  setpoint.mode.roll = (stab_mode_t)mode[3]; setpoint.mode.pitch = (stab_mode_t)mode[4];
  setpoint.mode.yaw = (stab_mode_t)mode[5]; setpoint.mode.quat = (stab_mode_t)mode[6]; setpoint.velocity_body = mode[7] != 0;
  controllerOutOfTree(&control, &setpoint, &sensors, &state, tick);
  out[0] = (float)control.controlMode; out[1] = control.thrustSi;
  out[2] = control.torqueX; out[3] = control.torqueY; out[4] = control.torqueZ;
}
/* s as above with the gyro in rad/s. r: position, velocity, acceleration, roll, pitch, yaw, yaw_rate, hold. out: rotor thrusts */
void plain(int first, const float *s, const float *r, float *out) {
  const gainproof_vec3 p = {s[0], s[1], s[2]}, v = {s[3], s[4], s[5]}, w = {s[10], s[11], s[12]};
  const gainproof_quaternion q = {s[6], s[7], s[8], s[9]};
  const gainproof_reference reference = {{r[0], r[1], r[2]}, {r[3], r[4], r[5]}, {r[6], r[7], r[8]}, r[9], r[10], r[11], r[12], r[13]};
  gainproof_measurement m; gainproof_command command;
  gainproof_measure(&p, &v, &q, &w, &m);
  if (first) gainproof_init(&beside, &m);
  gainproof_step(&beside, &reference, &m, &command);
  for (int i = 0; i < 4; i++) out[i] = command.rotor_thrust[i];
}
"""


def request(given, **settings):
    return Request(given, "5" * 64, SETTINGS | settings)


def folder(tmp_path, given, **settings):
    """Write an export with the firmware's headers beside it, and return the folder of its sources."""
    for name, content in TARGET.export(request(given, **settings)).files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)
    for name, text in STUBS.items():
        (tmp_path / name).write_text(text)
    return tmp_path / "src"


@pytest.mark.parametrize("compiler", ["gcc", "arm-none-eabi-gcc"])
@pytest.mark.parametrize(("position", "attitude"), [("pid", "pid"), ("ladrc", "hybrid")])
def test_it_compiles_without_a_warning(tmp_path, compiler, position, attitude):
    source = folder(tmp_path, controller(position, attitude, "crazyflie-pybullet", 0.002), form="controller")
    target = ARM if compiler.startswith("arm") else ()
    for file in sorted(source.glob("*.c")):
        output = file.with_suffix(".o")
        command = [
            program(compiler),
            *STRICT,
            *target,
            f"-I{tmp_path}",
            f"-I{source}",
            "-c",
            str(file),
            "-o",
            str(output),
        ]
        done = subprocess.run(command, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
    if target:
        symbols = subprocess.run(
            [
                program("arm-none-eabi-nm"),
                "-u",
                str(source / "controller_gainproof.o"),
                str(source / "gainproof_controller.o"),
            ],
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        assert not [line for line in symbols.splitlines() if "__aeabi_d" in line or "__aeabi_f2d" in line], symbols


def compiled(source, root):
    """The shared library of an export with its face."""
    (source / "face.c").write_text(FACE)
    files = [str(source / name) for name in ("face.c", "controller_gainproof.c", "gainproof_controller.c")]
    flags = ["-std=c11", "-O2", "-ffp-contract=off", "-shared", "-fPIC"]
    library = str(source / "face.so")
    subprocess.run([program("gcc"), *flags, f"-I{root}", f"-I{source}", *files, "-lm", "-o", library], check=True)
    return library


class Firmware:
    """The exported controller in a shared library, as the firmware calls it, and the C99 code called directly."""

    def __init__(self, library):
        self.code = ctypes.CDLL(str(library))
        self.code.begin()

    def fly(self, tick, state, setpoint, mode):
        out = np.zeros(5, np.float32)
        arrays = [np.asarray(state, np.float32), np.asarray(setpoint, np.float32), np.asarray(mode, np.int32), out]
        self.code.fly(ctypes.c_uint32(tick), *[a.ctypes.data_as(ctypes.c_void_p) for a in arrays])
        return out

    def heard(self):
        """What the firmware's PID was asked: inits, calls, thrust, modes of roll, pitch, yaw, z, and the control mode."""
        out = np.zeros(8, np.float32)
        self.code.heard(out.ctypes.data_as(ctypes.c_void_p))
        return out.tolist()

    def plain(self, first, state, reference):
        out = np.zeros(4, np.float32)
        arrays = [np.asarray(state, np.float32), np.asarray(reference, np.float32), out]
        self.code.plain(int(first), *[a.ctypes.data_as(ctypes.c_void_p) for a in arrays])
        return out


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The shared library of one controller, compiled once."""
    home = tmp_path_factory.mktemp("crazyflie")
    return compiled(folder(home, controller("ladrc", "hybrid", "crazyflie-pybullet", 0.002)), home)


@pytest.fixture
def firmware(built, tmp_path):
    """A copy of that library, whose variables are nobody else's."""
    return Firmware(shutil.copy(built, tmp_path / "face.so"))


def mixed(out):
    """Rotor thrusts that the firmware's mixing makes of force and torque, in our order of rotors (its 4, 1, 3, 2)."""
    _, thrust, x, y, z = out.astype(float)
    lever = 0.707106781 * float(ARM_LENGTH)
    roll, pitch, yaw = 0.25 / lever * x, 0.25 / lever * y, 0.25 * z / float(THRUST2TORQUE)
    m1, m2 = 0.25 * thrust - roll - pitch - yaw, 0.25 * thrust - roll + pitch + yaw
    m3, m4 = 0.25 * thrust + roll + pitch - yaw, 0.25 * thrust + roll - pitch + yaw
    return np.array([m4, m1, m3, m2])


ABS, SPEED, OFF = 1, 2, 0
HOLD = (ABS, ABS, ABS, OFF, OFF, ABS, OFF, 0)
DEGREE = np.float32(0.0174532925)


def flight(rng, steps):
    """States of a gentle flight, (steps, 13): our frames, gyro in rad/s."""
    t = np.arange(steps) * 0.002
    angles = [0.1 * np.sin(3 * t + rng.uniform(0, 6)) for _ in range(3)]
    states = np.zeros((steps, 13))
    states[:, :3] = 0.3 * np.sin(np.outer(t, rng.uniform(0.5, 2, 3)))
    states[:, 3:6] = 0.3 * np.cos(np.outer(t, rng.uniform(0.5, 2, 3)))
    half = 0.5 * np.array(angles)
    (cr, cp, cy), (sr, sp, sy) = np.cos(half), np.sin(half)
    states[:, 6] = cr * cp * cy + sr * sp * sy
    states[:, 7] = sr * cp * cy - cr * sp * sy
    states[:, 8] = cr * sp * cy + sr * cp * sy
    states[:, 9] = cr * cp * sy - sr * sp * cy
    states[:, 10:] = 0.3 * np.cos(np.outer(t, rng.uniform(1, 5, 3)))
    return states.astype(np.float32)


def in_degrees(state):
    """The state with the gyro as the firmware has it, and as the controller gets it back: in float32."""
    legacy = state.copy()
    legacy[10:] = state[10:] / DEGREE
    back = state.copy()
    back[10:] = DEGREE * legacy[10:]
    return legacy, back


def setpoint(**parts):
    places = {"position": 0, "velocity": 3, "acceleration": 6, "attitude": 9, "rate": 12, "quaternion": 15}
    flat = np.zeros(19, np.float32)
    flat[15] = 1.0
    for name, value in parts.items():
        flat[places[name] : places[name] + len(value)] = value
    return flat


def compare(firmware, states, given, mode, reference_of):
    """Fly both; the firmware is called every 1 ms, the plain code every 2 ms."""
    wanted = np.zeros(4)
    for k, state in enumerate(states):
        legacy, back = in_degrees(state)
        out = firmware.fly(2 * k, legacy, given, mode)
        wanted = firmware.plain(k == 0, back, reference_of(k, back))
        assert out[0] == 1.0
        # Sums and differences of four thrusts and their inverse, in float32: a few ulp of the largest.
        np.testing.assert_allclose(mixed(out), wanted, rtol=0, atol=8 * np.finfo(np.float32).eps * wanted.max())
        elsewhere = legacy.copy()
        elsewhere[:6] += np.float32(0.1)
        between = firmware.fly(2 * k + 1, elsewhere, given, mode)
        np.testing.assert_array_equal(between, out)
    assert np.ptp(wanted) > 1e-3  # the rotors had something to do


def test_a_position_setpoint_is_flown_as_the_c_code_flies_it(firmware):
    states = flight(np.random.default_rng(1), 60)
    given = setpoint(
        position=(0.2, -0.1, 0.3),
        velocity=(0.1, 0.2, -0.1),
        acceleration=(0.3, -0.2, 0.1),
        attitude=(0, 0, 20),
        rate=(0, 0, 5),
    )
    reference = [
        0.2,
        -0.1,
        0.3,
        0.1,
        0.2,
        -0.1,
        0.3,
        -0.2,
        0.1,
        0,
        0,
        DEGREE * np.float32(20),
        DEGREE * np.float32(5),
        1,
    ]
    compare(firmware, states, given, HOLD, lambda k, s: reference)


def test_attitude_setpoints_have_the_firmwares_signs_and_degrees(firmware):
    """Its pitch is positive nose up; x and y are free, altitude is held."""
    states = flight(np.random.default_rng(2), 40)
    given = setpoint(position=(0, 0, 0.4), attitude=(7, 11, -30))

    def reference(k, s):
        angles = DEGREE * np.array([7, -11, -30], np.float32)
        return [s[0], s[1], 0.4, 0, 0, 0, 0, 0, 0, *angles, 0, 0]

    compare(firmware, states, given, (OFF, OFF, ABS, ABS, ABS, ABS, OFF, 0), reference)


def test_velocity_setpoints_move_the_goal(firmware):
    """The goal starts where the vehicle is; without a yaw asked for, the heading at the start is kept."""
    states = flight(np.random.default_rng(3), 30)
    states[:, 6:10] = (1, 0, 0, 0)
    goal = states[0, :3].copy()
    speed = np.array([0.5, -0.4, 0.2], np.float32)

    def reference(k, s):
        goal[:] += np.float32(0.002) * speed
        return [*goal, *speed, 0, 0, 0, 0, 0, 0, 0, 1]

    compare(firmware, states, setpoint(velocity=speed), (SPEED, SPEED, SPEED, OFF, OFF, OFF, OFF, 0), reference)


def test_body_velocities_turn_with_the_heading(firmware):
    """Facing north, forward is north (+y) and left is west (-x)."""
    turned = np.zeros((12, 13), np.float32)
    turned[:, 6] = turned[:, 9] = np.sqrt(0.5)
    turned[:, 10] = 0.2
    goal = np.zeros(3, np.float32)

    def reference(k, s):
        goal[:2] += np.float32(0.002) * np.array([-0.3, 0.5], np.float32)
        return [*goal, -0.3, 0.5, 0, 0, 0, 0, 0, 0, np.float32(np.pi / 2), 0, 1]

    given = setpoint(velocity=(0.5, 0.3, 0), attitude=(0, 0, 90))
    mode = (SPEED, SPEED, ABS, OFF, OFF, ABS, OFF, 1)
    for k, state in enumerate(turned):
        legacy, back = in_degrees(state)
        out = firmware.fly(2 * k, legacy, given, mode)
        wanted = firmware.plain(k == 0, back, reference(k, back))
        # The heading is known to float32, so the goal moves by ulps of the speed asked for.
        np.testing.assert_allclose(mixed(out), wanted, rtol=0, atol=1e-5 * wanted.max())


def test_yaw_from_a_quaternion_and_from_a_rate(firmware):
    states = flight(np.random.default_rng(5), 20)
    states[:, 6:10] = (1, 0, 0, 0)
    half = math.radians(15)
    given = setpoint(quaternion=(math.cos(half), 0, 0, math.sin(half)))
    yaw = np.float32(2 * half)
    compare(firmware, states, given, (ABS, ABS, ABS, OFF, OFF, OFF, ABS, 0), lambda k, s: [0] * 11 + [yaw, 0, 1])
    firmware.code.begin()

    def turning(k, s):
        rate = DEGREE * np.float32(40)
        angle = np.float32(0)
        for _ in range(k + 1):
            angle = np.float32(angle + np.float32(np.float32(0.002) * DEGREE) * np.float32(40))
        return [0] * 11 + [angle, rate, 1]

    compare(firmware, states, setpoint(rate=(0, 0, 40)), (ABS, ABS, ABS, OFF, OFF, SPEED, OFF, 0), turning)


def test_thrust_by_hand_stops_the_motors_and_the_next_flight_starts_fresh(firmware):
    states = flight(np.random.default_rng(6), 10)
    compare(firmware, states, setpoint(), HOLD, lambda k, s: [0] * 13 + [1])
    stopped = firmware.fly(21, in_degrees(states[0])[0], setpoint(), (OFF,) * 8)
    assert stopped[1:].tolist() == [0, 0, 0, 0]
    compare(firmware, states, setpoint(), HOLD, lambda k, s: [0] * 13 + [1])


def test_a_measurement_that_is_not_finite_leaves_the_command_in_force(firmware):
    state = flight(np.random.default_rng(7), 1)[0]
    before = firmware.fly(0, state, setpoint(), HOLD)
    broken = state.copy()
    broken[4] = np.nan
    assert firmware.fly(2, broken, setpoint(), HOLD).tolist() == before.tolist()
    broken = state.copy()
    broken[6:10] = 0.0
    assert firmware.fly(4, broken, setpoint(), HOLD).tolist() == before.tolist()


# 50 ms of the last command, in periods of 2 ms; the next one hands over.
PATIENCE = 25


def lost(firmware, state, broken, periods=PATIENCE):
    """Fly once, then periods of a broken measurement; the last command before and what is commanded after them."""
    before = firmware.fly(0, state, setpoint(), HOLD)
    for k in range(1, periods + 1):
        assert firmware.fly(2 * k, broken, setpoint(), HOLD).tolist() == before.tolist()
    return 2 * (periods + 1)


def without(state, entry):
    broken = state.copy()
    broken[entry] = np.nan
    return broken


@pytest.mark.parametrize("entry", [2, 4])
def test_without_a_position_the_firmwares_own_pid_levels_and_sinks(firmware, entry):
    state = flight(np.random.default_rng(9), 1)[0]
    tick = lost(firmware, state, without(state, entry))
    out = firmware.fly(tick, without(state, entry), setpoint(), HOLD)
    inits, calls, thrust, roll, pitch, yaw, z, mode = firmware.heard()
    assert out[1] == -1.0 and (inits, calls, mode) == (1.0, 1.0, 0.0)
    assert (roll, pitch, yaw, z) == (ABS, ABS, SPEED, OFF)
    hover = 0.027 * 9.81 / 4.0 / float(np.float32(0.1125)) * 65535.0
    assert thrust == pytest.approx(0.9 * hover, rel=1e-5)
    # A measurement that comes back changes nothing; it goes on at every tick until somebody takes over by hand.
    assert firmware.fly(tick + 1, state, setpoint(), HOLD)[1] == -1.0 and firmware.heard()[1] == 2.0
    assert firmware.fly(tick + 2, state, setpoint(), (OFF,) * 8)[1:].tolist() == [0, 0, 0, 0]
    assert firmware.fly(tick + 4, state, setpoint(), HOLD)[1] > 0.0


@pytest.mark.parametrize("entry", [6, 11])
def test_without_an_attitude_the_motors_stop(firmware, entry):
    state = flight(np.random.default_rng(10), 1)[0]
    tick = lost(firmware, state, without(state, entry))
    assert firmware.fly(tick, without(state, entry), setpoint(), HOLD)[1:].tolist() == [0, 0, 0, 0]
    assert firmware.fly(tick + 2, state, setpoint(), HOLD)[1:].tolist() == [0, 0, 0, 0]
    assert firmware.heard()[1] == 0.0


def test_levelled_and_then_without_a_gyro_the_motors_stop(firmware):
    state = flight(np.random.default_rng(11), 1)[0]
    tick = lost(firmware, state, without(state, 4))
    firmware.fly(tick, without(state, 4), setpoint(), HOLD)
    assert firmware.fly(tick + 1, without(state, 11), setpoint(), HOLD)[1:].tolist() == [0, 0, 0, 0]
    assert firmware.fly(tick + 2, state, setpoint(), HOLD)[1:].tolist() == [0, 0, 0, 0]


def test_a_measurement_in_time_starts_the_count_again(firmware):
    state = flight(np.random.default_rng(12), 1)[0]
    tick = lost(firmware, state, without(state, 4))
    firmware.fly(tick, state, setpoint(), HOLD)
    command = firmware.fly(tick + 2, state, setpoint(), HOLD)
    assert firmware.fly(tick + 4, without(state, 4), setpoint(), HOLD).tolist() == command.tolist()
    assert firmware.heard()[1] == 0.0


@pytest.mark.parametrize(
    ("airframe", "thrust_max", "words"),
    [
        ("iris", "0.1125f", "differ more than twice"),
        ("crazyflie-pybullet", "5.6f", "differ more than twice"),
        ("crazyflie-pybullet", "0.0745f", "differ more than twice"),
        ("crazyflie-pybullet", "0.1625f", ""),
    ],
)
def test_it_builds_for_the_rotors_that_the_gains_are_for_alone(tmp_path, airframe, thrust_max, words):
    source = folder(tmp_path, controller("ladrc", "hybrid", airframe, 0.002))
    defaults = tmp_path / "platform_defaults.h"
    defaults.write_text(defaults.read_text().replace("0.1125f", thrust_max))
    command = [
        program("gcc"),
        *STRICT,
        f"-I{tmp_path}",
        f"-I{source}",
        "-c",
        str(source / "controller_gainproof.c"),
        "-o",
        "/dev/null",
    ]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode == 0, words in done.stderr) == (not words, True), done.stderr


def test_motors_are_named_by_the_firmwares_numbers():
    """Motor 1 front right counter-clockwise, then clockwise round the vehicle: 2 rear right, 3 rear left, 4 front left."""
    text = (
        TARGET.export(request(controller("ladrc", "hybrid", "crazyflie-pybullet", 0.002))).files["README.md"].decode()
    )
    assert (
        "motor 1 front right counter-clockwise, motor 2 rear right clockwise, motor 3 rear left counter-clockwise, "
        "motor 4 front left clockwise" in text
    )


def test_a_torque_turns_the_vehicle_as_the_firmware_means_it(firmware):
    """Asked to the left (+y) the vehicle rolls left side down: less thrust left; asked ahead (+x), less thrust in front."""
    still = np.zeros(13, np.float32)
    still[6] = 1.0
    left = mixed(firmware.fly(0, still, setpoint(position=(0, 1, 0)), HOLD))
    assert left[0] < left[1] and left[2] < left[3]
    firmware.code.begin()
    ahead = mixed(firmware.fly(0, still, setpoint(position=(1, 0, 0)), HOLD))
    assert ahead[0] < ahead[2] and ahead[1] < ahead[3]


@pytest.mark.parametrize("law", list(LAWS))
def test_every_law_can_be_carried(law):
    bundle = TARGET.export(request(controller(law, law, "crazyflie-pybullet", 0.002), form="controller"))
    assert set(bundle.files) == set(bundle.rollback)
    text = bundle.files["src/controller_gainproof.c"].decode()
    for word in ("5" * 64, "crazyflie-pybullet", f"position {law}", "gainproof", "PERIOD_TICKS 2U"):
        assert word in text
    assert "@" not in text + bundle.files["README.md"].decode()


def test_the_rollback_is_what_was_flown_before(tmp_path):
    flown = controller("ladrc", "hybrid", "crazyflie-pybullet", 0.002, roll__k2=7.5)
    previous = tmp_path / "gains.json"
    previous.write_text(json.dumps(to_document(flown, {})))
    given = controller("pid", "hybrid", "crazyflie-pybullet", 0.002)
    back = TARGET.export(Request(given, "5" * 64, SETTINGS, previous)).rollback
    assert (
        back["src/gainproof_controller.c"]
        == TARGET.export(
            Request(flown, back["src/gainproof_controller.h"].decode().split("gains ")[1].split()[0], SETTINGS)
        ).files["src/gainproof_controller.c"]
    )
    assert b"7.5" in back["src/gainproof_controller.c"]


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"period": 0.0025}, "controller.control_period.*2.5 ms"),
        ({"period": 0.0004}, "controller.control_period.*0.4 ms"),
        ({"airframe": "hummingbird-rotors"}, "airframe"),
    ],
)
def test_what_the_firmware_cannot_do_is_refused_by_name(change, key):
    given = controller("ladrc", "hybrid", **({"airframe": "crazyflie-pybullet"} | change))
    with pytest.raises(InputError, match=key):
        TARGET.export(request(given))


def test_delay_is_flown(tmp_path):
    given = controller("pid", "hybrid", "crazyflie-pybullet", 0.002, ControlOptions(delay=True))
    firmware = Firmware(compiled(folder(tmp_path, given), tmp_path))
    states = flight(np.random.default_rng(8), 20)
    compare(firmware, states, setpoint(position=(0.2, 0.1, 0)), HOLD, lambda k, s: [0.2, 0.1] + [0] * 11 + [1])
