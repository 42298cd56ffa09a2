/* libFuzzer target: any bytes as a measurement and a run of steps. Finite numbers in must give finite numbers out, and what is
   refused must leave the state and repeat the output. */

#include "holdfast_controller.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define STEP (sizeof(holdfast_reference) + sizeof(holdfast_measurement))
#define ATTITUDE (sizeof(holdfast_attitude_setpoint) + sizeof(holdfast_attitude_measurement) + sizeof(holdfast_attitude_applied))

static int all_finite(const void *numbers, size_t bytes)
{
    holdfast_real value;
    size_t i;
    for (i = 0; i + sizeof value <= bytes; i += sizeof value) {
        memcpy(&value, (const char *)numbers + i, sizeof value);
        if (!isfinite(value))
            return 0;
    }
    return 1;
}

static void check(int fine)
{
    if (!fine)
        abort();
}

static void cascade(const uint8_t *data, size_t size)
{
    holdfast_state state, before;
    holdfast_reference reference;
    holdfast_measurement m;
    holdfast_command command, last;
    memcpy(&m, data, sizeof m);
    if (holdfast_init(&state, &m) != HOLDFAST_OK)
        return;
    check(all_finite(&state, sizeof state));
    last = state.command;
    for (data += sizeof m, size -= sizeof m; size >= STEP; data += STEP, size -= STEP) {
        memcpy(&reference, data, sizeof reference);
        memcpy(&m, data + sizeof reference, sizeof m);
        before = state;
        if (holdfast_step(&state, &reference, &m, &command) == HOLDFAST_OK)
            check(all_finite(data, STEP));
        else
            check(memcmp(&state, &before, sizeof state) == 0 && memcmp(&command, &last, sizeof command) == 0);
        check(all_finite(&state, sizeof state) && all_finite(&command, sizeof command));
        last = command;
    }
}

static void attitude(const uint8_t *data, size_t size)
{
    holdfast_attitude_state state, before;
    holdfast_attitude_setpoint setpoint;
    holdfast_attitude_measurement m;
    holdfast_attitude_applied applied;
    holdfast_vec3 torque, last = {0, 0, 0};
    memcpy(&m, data, sizeof m);
    if (holdfast_attitude_init(&state, &m) != HOLDFAST_OK)
        return;
    for (data += sizeof m, size -= sizeof m; size >= ATTITUDE; data += ATTITUDE, size -= ATTITUDE) {
        memcpy(&setpoint, data, sizeof setpoint);
        memcpy(&m, data + sizeof setpoint, sizeof m);
        memcpy(&applied, data + sizeof setpoint + sizeof m, sizeof applied);
        before = state;
        if (holdfast_attitude_step(&state, &setpoint, &m, &applied, &torque) == HOLDFAST_OK)
            check(all_finite(data, ATTITUDE));
        else
            check(memcmp(&state, &before, sizeof state) == 0 && memcmp(&torque, &last, sizeof torque) == 0);
        check(all_finite(&state, sizeof state) && all_finite(&torque, sizeof torque));
        last = torque;
    }
}

static void measure(const uint8_t *data)
{
    holdfast_vec3 places[3];
    holdfast_quaternion q;
    holdfast_measurement m;
    memcpy(places, data, sizeof places);
    memcpy(&q, data + sizeof places, sizeof q);
    if (holdfast_measure(&places[0], &places[1], &q, &places[2], &m) == HOLDFAST_OK)
        check(all_finite(data, sizeof places + sizeof q) && all_finite(&m, sizeof m));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size >= sizeof(holdfast_measurement)) {
        measure(data);
        cascade(data, size);
        attitude(data, size);
    }
    return 0;
}
