/* Betaflight's own rate controller, stepped by hand: built with the firmware's sources beside the project, see betaflight_pid.py.
 * Written here; it stands in for sticks, motors and sensors, and gives the controller nothing but gyro, attitude and setpoints. */

#include <stdbool.h>
#include <string.h>

#include "platform.h"

#include "build/debug.h"
#include "common/filter.h"
#include "fc/core.h"
#include "fc/runtime_config.h"
#include "flight/imu.h"
#include "flight/pid.h"
#include "flight/pid_init.h"
#include "pg/pg.h"
#include "rx/rx.h"
#include "sensors/acceleration.h"
#include "sensors/gyro.h"

gyro_t gyro;
attitudeEulerAngles_t attitude;
acc_t acc;
accelerometerConfig_t accelerometerConfig_System;
uint8_t armingFlags;
uint16_t flightModeFlags;
int16_t debug[DEBUG16_VALUE_COUNT];
uint8_t debugMode;
rxRuntimeState_t rxRuntimeState;

static float asked[3];
static pidProfile_t profile;
static pt1Filter_t first[3], second[3];
static biquadFilter_t notch[3];
static bool notched;
static float throttle;

float getSetpointRate(int axis) { return asked[axis]; }
float getMaxRcRate(int axis) { (void)axis; return profile.angle_limit; }
float getFeedforward(int axis) { (void)axis; return 0.0f; }
float getRcDeflection(int axis) { (void)axis; return 0.0f; }
float getMaxRcDeflectionAbs(void) { return 0.0f; }
float mixerGetRcThrottle(void) { return 0.3f; }
float dynThrottle(float throttle) { return throttle; }
float getMotorMixRange(void) { return 0.0f; }
bool gyroOverflowDetected(void) { return false; }
bool gyroYawSpinDetected(void) { return false; }
bool isLaunchControlActive(void) { return false; }
bool wasThrottleRaised(void) { return true; }
bool sensors(uint32_t mask) { (void)mask; return true; }
void disarm(flightLogDisarmReason_e reason) { (void)reason; }
void setArmingDisabled(armingDisableFlags_e flag) { (void)flag; }

static const double nothing[3];
static const int level[3];

/* setpoint: of the rate [deg/s], or of the angle [deg] in angle mode; rate [deg/s]; angle [0.1 deg]; sum: what goes to the mixer. */
void betaflight_step(const double *setpoint, const double *rate, const int *angle, double *sum)
{
    for (int axis = 0; axis < 3; axis++) {
        float filtered = pt1FilterApply(&second[axis], (float)rate[axis]);
        if (notched) {
            filtered = biquadFilterApply(&notch[axis], filtered);
        }
        gyro.gyroADCf[axis] = pt1FilterApply(&first[axis], filtered);
        asked[axis] = (float)setpoint[axis];
        attitude.raw[axis] = angle[axis];
    }
    pidUpdateTpaFactor(throttle);
    pidController(&profile, 0);
    for (int axis = 0; axis < 3; axis++) {
        sum[axis] = pidData[axis].Sum;
    }
}

/* gains: p, i, d of roll, pitch, yaw, then angle_p_gain; filters [Hz]: gyro 1 and 2, notch and its cut-off, D 1 and 2, yaw;
 * large: throttle [%], tpa_rate, tpa_breakpoint, tpa_mode, iterm_relax, iterm_relax_cutoff. */
void betaflight_start(const int *gains, const int *filters, const int *large, int microseconds, int angle_mode)
{
    double sum[3];

    memset(&gyro, 0, sizeof gyro);
    memset(&pidRuntime, 0, sizeof pidRuntime);
    memset(pidData, 0, sizeof pidData);
    resetPidProfile(&profile);
    for (int axis = 0; axis < 3; axis++) {
        profile.pid[axis].P = gains[3 * axis];
        profile.pid[axis].I = gains[3 * axis + 1];
        profile.pid[axis].D = gains[3 * axis + 2];
        profile.pid[axis].F = 0;
        profile.d_max[axis] = 0;
    }
    profile.pid[PID_LEVEL].P = gains[9];
    profile.pid[PID_LEVEL].F = 0;
    profile.anti_gravity_gain = 0;
    profile.tpa_rate = large[1];
    profile.tpa_breakpoint = large[2];
    profile.tpa_mode = large[3];
    profile.iterm_relax = large[4];
    profile.iterm_relax_cutoff = large[5];
    profile.angle_earth_ref = 0;
    profile.angle_limit = 80;
    profile.dterm_lpf1_dyn_min_hz = 0;
    profile.dterm_lpf1_static_hz = filters[4];
    profile.dterm_lpf2_static_hz = filters[5];
    profile.yaw_lowpass_hz = filters[6];
    pidConfigMutable()->pid_process_denom = 1;
    gyro.targetLooptime = microseconds;
    flightModeFlags = angle_mode ? ANGLE_MODE : 0;
    /* Twice, as the firmware does while it starts: the first finds I-term relax still off and leaves its filter out. */
    pidInit(&profile);
    pidInit(&profile);
    pidStabilisationState(PID_STABILISATION_ON);
    throttle = 0.01f * large[0];
    notched = filters[2] && filters[3];
    for (int axis = 0; axis < 3; axis++) {
        pt1FilterInit(&first[axis], filters[0] ? pt1FilterGain(filters[0], 1e-6f * microseconds) : 1.0f);
        pt1FilterInit(&second[axis], filters[1] ? pt1FilterGain(filters[1], 1e-6f * microseconds) : 1.0f);
        if (notched) {
            biquadFilterInit(&notch[axis], filters[2], microseconds, filterGetNotchQ(filters[2], filters[3]), FILTER_NOTCH, 1.0f);
        }
    }
    /* At rest: the controller keeps the last rate behind the filters of D to itself, from one start to the next. */
    betaflight_step(nothing, nothing, level, sum);
}
