/* What the Crazyflie's module has beside its Python: objects of gains, functions that set them, the gyro's filter, which passes all. */
#include <stdbool.h>

typedef struct { float kp, ki, kd, kff, cutoff; } gains;

gains pidRoll, pidPitch, pidYaw, pidRollRate, pidPitchRate, pidYawRate;

void pidSetKp(gains *pid, const float value) { pid->kp = value; }
void pidSetKi(gains *pid, const float value) { pid->ki = value; }
void pidSetKd(gains *pid, const float value) { pid->kd = value; }
void pidSetKff(gains *pid, const float value) { pid->kff = value; }
void filterReset(gains *pid, const float rate, const float cutoff, bool on) { pid->cutoff = on && rate == 500.0f ? cutoff : -1.0f; }

void lpf2pInit(float *filter, float rate, float cutoff) { *filter = rate == 1000.0f && cutoff == 80.0f ? 1.0f : 0.0f; }
float lpf2pApply(float *filter, float sample) { return *filter * sample; }
