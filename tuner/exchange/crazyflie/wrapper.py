"""An out-of-tree controller for the Crazyflie's firmware around the C99 code of a controller.

bitcraze/crazyflie-firmware, docs/development/oot.md and src/modules/interface/stabilizer_types.h. The firmware gives position
[m], velocity [m/s] and the attitude quaternion in our frames, gyro rates in deg/s about our axes, and setpoints of attitude in
degrees with pitch positive nose up, the opposite of ours. Torques are written so that the firmware's mixing, with its own arm
and its own torque per thrust, ends at the very rotor thrusts that the controller decided, whatever the airframe's arm and
propellers are: at 0.0397 m instead of the firmware's 0.046 m, torques as they are would come out 14 % small.
"""

from plant.airframes.actuation import actuation
from tuner.exchange.autopilot.scales import motors_text
from tuner.exchange.crazyflie.map import MOTORS
from tuner.exchange.target import Request
from tuner.exchange.texts import c_comment, heading, markdown

NAME = "controller_holdfast"
TICK = 0.001
"""Period of the firmware's stabilizer loop [s]."""

_CONTROLLER = """\
/* Out-of-tree controller of the Crazyflie's firmware.
@HEADING@
 */
#include "controller_holdfast.h"

#include <math.h>

#include "controller_pid.h"
#include "holdfast_controller.h"
#include "platform_defaults.h"

#if RATE_MAIN_LOOP != 1000
#error "the control period is counted in ticks of 1 ms"
#endif

/* The gains are for rotors of @ROTOR_MAX@ N at most; with others they fly another vehicle, or none. */
#define ROTOR_MAX @ROTOR_MAX@F /* [N] */
#define ROTOR_HOVER @ROTOR_HOVER@F /* [N] */
_Static_assert(THRUST_MAX > 0.5F * ROTOR_MAX && THRUST_MAX < 2.0F * ROTOR_MAX,
               "THRUST_MAX of this firmware and the rotors that the gains are for differ more than twice");
_Static_assert(THRUST_MAX > 1.1F * ROTOR_HOVER, "THRUST_MAX of this firmware does not lift the vehicle that the gains are for");

#define PERIOD_TICKS @TICKS@U
#define PERIOD @PERIOD@F /* s */
#define DEGREE 0.0174532925F /* rad */
/* Lever of the firmware's mixing: motors at 45 deg on the arm [m]. */
#define LEVER (0.707106781F * ARM_LENGTH)

static holdfast_state controller;
static holdfast_vec3 goal; /* where the vehicle is asked to be, world ENU [m] */
static float yaw_goal;     /* rad */
static bool flying;
/* Periods in a row without a measurement that can be used, and how many hold the last command: PATIENCE ms at most. */
static unsigned int missed;
#define PATIENCE 50U
#define MOST_MISSED (PATIENCE / PERIOD_TICKS)
static enum { OURS, LEVELLED, STOPPED } in_charge;
static float rotor_thrust[4]; /* in force, front left, front right, rear left, rear right [N] */

static void stop(void)
{
    flying = false;
    missed = 0U;
    in_charge = OURS;
    for (int i = 0; i < 4; i++)
        rotor_thrust[i] = 0.0F;
}

void controllerOutOfTreeInit(void)
{
    stop();
}

bool controllerOutOfTreeTest(void)
{
    return true;
}

/* Moves a goal with the setpoint: to the place asked for, or on at the speed asked for [m, m/s]. */
static float moved(float from, stab_mode_t mode, float place, float speed)
{
    return mode == modeVelocity ? from + PERIOD * speed : place;
}

static float yaw_asked(const setpoint_t *setpoint)
{
    const quaternion_t *q = &setpoint->attitudeQuaternion;
    if (setpoint->mode.yaw == modeVelocity)
        return yaw_goal + PERIOD * DEGREE * setpoint->attitudeRate.yaw;
    if (setpoint->mode.yaw == modeAbs)
        return DEGREE * setpoint->attitude.yaw;
    if (setpoint->mode.quat == modeAbs)
        return atan2f(2.0F * (q->w * q->z + q->x * q->y), 1.0F - 2.0F * (q->y * q->y + q->z * q->z));
    return yaw_goal;
}

static holdfast_reference asked(const setpoint_t *setpoint, const holdfast_measurement *m)
{
    holdfast_reference r = {0};
    const bool tracked = setpoint->mode.x != modeDisable && setpoint->mode.y != modeDisable;
    float east = setpoint->velocity.x, north = setpoint->velocity.y;
    if (setpoint->velocity_body) {
        east = m->heading.x * setpoint->velocity.x - m->heading.y * setpoint->velocity.y;
        north = m->heading.y * setpoint->velocity.x + m->heading.x * setpoint->velocity.y;
    }
    goal.x = tracked ? moved(goal.x, setpoint->mode.x, setpoint->position.x, east) : m->position.x;
    goal.y = tracked ? moved(goal.y, setpoint->mode.y, setpoint->position.y, north) : m->position.y;
    goal.z = moved(goal.z, setpoint->mode.z, setpoint->position.z, setpoint->velocity.z);
    yaw_goal = yaw_asked(setpoint);
    r.position = goal;
    r.velocity.x = east;
    r.velocity.y = north;
    r.velocity.z = setpoint->velocity.z;
    r.acceleration.x = setpoint->acceleration.x;
    r.acceleration.y = setpoint->acceleration.y;
    r.acceleration.z = setpoint->acceleration.z;
    if (setpoint->mode.roll == modeAbs)
        r.roll = DEGREE * setpoint->attitude.roll;
    if (setpoint->mode.pitch == modeAbs)
        r.pitch = -DEGREE * setpoint->attitude.pitch; /* the firmware's pitch is positive nose up, ours nose down */
    r.yaw = yaw_goal;
    r.yaw_rate = DEGREE * setpoint->attitudeRate.yaw;
    r.hold = tracked ? 1.0F : 0.0F;
    return r;
}

/* One control period; false where nothing could be decided, which leaves the last command in force. */
static bool decide(const setpoint_t *setpoint, const sensorData_t *sensors, const state_t *state)
{
    const holdfast_vec3 position = {state->position.x, state->position.y, state->position.z};
    const holdfast_vec3 velocity = {state->velocity.x, state->velocity.y, state->velocity.z};
    const holdfast_quaternion attitude = {state->attitudeQuaternion.w, state->attitudeQuaternion.x,
                                          state->attitudeQuaternion.y, state->attitudeQuaternion.z};
    const holdfast_vec3 rate = {DEGREE * sensors->gyro.x, DEGREE * sensors->gyro.y, DEGREE * sensors->gyro.z};
    holdfast_measurement m;
    holdfast_command command;
    if (holdfast_measure(&position, &velocity, &attitude, &rate, &m) != HOLDFAST_OK)
        return false;
    if (!flying) {
        if (holdfast_init(&controller, &m) != HOLDFAST_OK)
            return false;
        goal = position;
        yaw_goal = m.angles.z;
        flying = true;
    }
    const holdfast_reference reference = asked(setpoint, &m);
    if (holdfast_step(&controller, &reference, &m, &command) != HOLDFAST_OK)
        return false;
    for (int i = 0; i < 4; i++)
        rotor_thrust[i] = command.rotor_thrust[i];
    return true;
}

static bool is_finite(float x)
{
    return x - x == 0.0F;
}

/* What the firmware's own PID needs to keep the vehicle level. */
static bool angles_known(const sensorData_t *sensors, const state_t *state)
{
    const Axis3f *rate = &sensors->gyro;
    const attitude_t *angle = &state->attitude;
    return is_finite(rate->x) && is_finite(rate->y) && is_finite(rate->z) && is_finite(angle->roll) && is_finite(angle->pitch)
        && is_finite(angle->yaw);
}

/* After MOST_MISSED periods others are in charge until thrust by hand or motors off is asked for: the firmware's own PID, or
   nobody, and the motors stand still. */
static void hand_over(const sensorData_t *sensors, const state_t *state)
{
    const bool known = angles_known(sensors, state);
    stop();
    in_charge = known ? LEVELLED : STOPPED;
    if (known)
        controllerPidInit();
}

/* The firmware's PID, asked to be level, not to turn, and to sink: nine tenths of the weight, in its counts. */
static void level(control_t *control, const sensorData_t *sensors, const state_t *state, const stabilizerStep_t stabilizerStep)
{
    setpoint_t setpoint = {0};
    setpoint.mode.roll = modeAbs;
    setpoint.mode.pitch = modeAbs;
    setpoint.mode.yaw = modeVelocity;
    setpoint.thrust = 0.9F * 65535.0F * ROTOR_HOVER / THRUST_MAX;
    control->controlMode = controlModeLegacy;
    controllerPid(control, &setpoint, sensors, state, stabilizerStep);
}

/* Force and torques from which the firmware's mixing gets these rotor thrusts back. */
static void put(control_t *control)
{
    const float *t = rotor_thrust;
    control->controlMode = controlModeForceTorque;
    control->thrustSi = t[0] + t[1] + t[2] + t[3];
    control->torqueX = LEVER * (t[0] + t[2] - t[1] - t[3]);
    control->torqueY = LEVER * (t[2] + t[3] - t[0] - t[1]);
    control->torqueZ = THRUST2TORQUE * (t[0] + t[3] - t[1] - t[2]);
}

void controllerOutOfTree(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors, const state_t *state,
                         const stabilizerStep_t stabilizerStep)
{
    if (setpoint->mode.z == modeDisable) {
        stop(); /* thrust by hand, or motors off: nothing that this controller flies */
    } else if (in_charge == OURS && stabilizerStep % PERIOD_TICKS == 0U) {
        missed = decide(setpoint, sensors, state) ? 0U : missed + 1U;
        if (missed > MOST_MISSED)
            hand_over(sensors, state);
    }
    if (in_charge == LEVELLED && !angles_known(sensors, state))
        in_charge = STOPPED;
    if (in_charge == LEVELLED)
        level(control, sensors, state, stabilizerStep);
    else
        put(control);
}
"""

_HEADER = """\
#ifndef CONTROLLER_HOLDFAST_H
#define CONTROLLER_HOLDFAST_H

#include <stdbool.h>

#include "stabilizer_types.h"

void controllerOutOfTreeInit(void);
bool controllerOutOfTreeTest(void);
void controllerOutOfTree(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors, const state_t *state,
                         const stabilizerStep_t stabilizerStep);

#endif
"""

_APP = """\
/* The firmware wants an app beside the controller; this one sleeps. */
#include "FreeRTOS.h"
#include "app.h"
#include "task.h"

void appMain(void)
{
    for (;;)
        vTaskDelay(M2T(10000));
}
"""

# Contracted products would round otherwise than the golden vectors of the C99 export.
_KBUILD = """\
obj-y += app_main.o
obj-y += controller_holdfast.o
obj-y += holdfast_controller.o
CFLAGS_controller_holdfast.o += -ffp-contract=off
CFLAGS_holdfast_controller.o += -ffp-contract=off
"""

_MAKEFILE = """\
CRAZYFLIE_BASE ?= ../crazyflie-firmware
OOT_CONFIG := $(PWD)/app-config
include $(CRAZYFLIE_BASE)/tools/make/oot.mk
"""

_CONFIG = """\
CONFIG_APP_ENABLE=y
CONFIG_APP_PRIORITY=1
CONFIG_APP_STACKSIZE=350
CONFIG_CONTROLLER_OOT=y
"""

_README = """\
# Out-of-tree controller for the Crazyflie

@HEADING@

Build it beside the firmware (https://github.com/bitcraze/crazyflie-firmware, `make cf2_defconfig` done there):

    make CRAZYFLIE_BASE=/path/to/crazyflie-firmware

and flash `cf2.bin` with `make cload`. Then set the parameter `stabilizer.controller` to the number that `controller.h` of your
firmware gives the out-of-tree controller.

- It decides every @PERIOD@ ms, on the firmware's loop of 1 kHz, and holds its command in between.
- Setpoints of position and of velocity (world or body) are flown, as are roll and pitch while z is held (mode x or y disabled).
  With mode z disabled (thrust by hand, motors off) the motors stand still.
- Torques go through the firmware's own ARM_LENGTH and THRUST2TORQUE, so the rotors get the thrusts that the controller decided.
- Measurements that are not finite, or an attitude that is none, hold the last command for 50 ms. Then the firmware's own PID
  keeps the vehicle level and sinking while gyro and attitude are finite, else the motors stop; both until mode z is disabled.
- It does not build where THRUST_MAX of your firmware and the rotors that the gains are for (@THRUST@ N) differ more than twice,
  or where THRUST_MAX does not lift the vehicle.
- The motors, by the firmware's numbers: @MOTORS@.
- First flight: tethered, or with a hand on the emergency stop.
"""


def files(request: Request, header: str, source: str, sentence: str = "") -> dict[str, bytes]:
    """Return name -> content of the firmware's out-of-tree folder; header, source: of the C99 controller in float."""
    controller = request.controller
    told = [text for text in (*heading(request, str), sentence) if text]
    ticks = round(controller.control_period / TICK)
    vehicle = controller.airframe.vehicle
    rotors = actuation(vehicle)
    tokens = {"@TICKS@": str(ticks), "@PERIOD@": f"{controller.control_period:.9g}"}
    tokens |= {"@ROTOR_MAX@": f"{rotors.thrust_max:#.9g}", "@ROTOR_HOVER@": f"{rotors.hover_thrust:#.9g}"}
    readme = {"@HEADING@": "  \n".join(map(markdown, told)), "@PERIOD@": str(ticks)}
    readme |= {"@THRUST@": f"{rotors.thrust_max:.4g}", "@MOTORS@": motors_text(rotors, MOTORS)}
    texts = {
        "Kbuild": "obj-y += src/\n",
        "Makefile": _MAKEFILE,
        "README.md": filled(_README, readme),
        "app-config": _CONFIG,
        "src/Kbuild": _KBUILD,
        "src/app_main.c": _APP,
        f"src/{NAME}.c": filled(
            _CONTROLLER, tokens | {"@HEADING@": "\n".join(f" * {c_comment(text)}" for text in told)}
        ),
        f"src/{NAME}.h": _HEADER,
        "src/holdfast_controller.c": source,
        "src/holdfast_controller.h": header,
    }
    return {name: text.encode("ascii", "backslashreplace") for name, text in texts.items()}


def filled(template: str, tokens: dict[str, str]) -> str:
    """Return a template with its tokens replaced."""
    for token, value in tokens.items():
        template = template.replace(token, value)
    return template
