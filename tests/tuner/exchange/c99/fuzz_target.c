/* libFuzzer target: any bytes as a measurement and a run of steps. Finite numbers in must give finite numbers out, and what is
   refused must leave the state and repeat the output. */

#include "gainproof_controller.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define STEP (sizeof(gainproof_reference) + sizeof(gainproof_measurement))
#define ATTITUDE (sizeof(gainproof_attitude_setpoint) + sizeof(gainproof_attitude_measurement) + sizeof(gainproof_attitude_applied))

static int all_finite(const void *numbers, size_t bytes)
{
    gainproof_real value;
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
    gainproof_state state, before;
    gainproof_reference reference;
    gainproof_measurement m;
    gainproof_command command, last;
    memcpy(&m, data, sizeof m);
    if (gainproof_init(&state, &m) != GAINPROOF_OK)
        return;
    check(all_finite(&state, sizeof state));
    last = state.command;
    for (data += sizeof m, size -= sizeof m; size >= STEP; data += STEP, size -= STEP) {
        memcpy(&reference, data, sizeof reference);
        memcpy(&m, data + sizeof reference, sizeof m);
        before = state;
        if (gainproof_step(&state, &reference, &m, &command) == GAINPROOF_OK)
            check(all_finite(data, STEP));
        else
            check(memcmp(&state, &before, sizeof state) == 0 && memcmp(&command, &last, sizeof command) == 0);
        check(all_finite(&state, sizeof state) && all_finite(&command, sizeof command));
        last = command;
    }
}

static void attitude(const uint8_t *data, size_t size)
{
    gainproof_attitude_state state, before;
    gainproof_attitude_setpoint setpoint;
    gainproof_attitude_measurement m;
    gainproof_attitude_applied applied;
    gainproof_vec3 torque, last = {0, 0, 0};
    memcpy(&m, data, sizeof m);
    if (gainproof_attitude_init(&state, &m) != GAINPROOF_OK)
        return;
    for (data += sizeof m, size -= sizeof m; size >= ATTITUDE; data += ATTITUDE, size -= ATTITUDE) {
        memcpy(&setpoint, data, sizeof setpoint);
        memcpy(&m, data + sizeof setpoint, sizeof m);
        memcpy(&applied, data + sizeof setpoint + sizeof m, sizeof applied);
        before = state;
        if (gainproof_attitude_step(&state, &setpoint, &m, &applied, &torque) == GAINPROOF_OK)
            check(all_finite(data, ATTITUDE));
        else
            check(memcmp(&state, &before, sizeof state) == 0 && memcmp(&torque, &last, sizeof torque) == 0);
        check(all_finite(&state, sizeof state) && all_finite(&torque, sizeof torque));
        last = torque;
    }
}

static void measure(const uint8_t *data)
{
    gainproof_vec3 places[3];
    gainproof_quaternion q;
    gainproof_measurement m;
    memcpy(places, data, sizeof places);
    memcpy(&q, data + sizeof places, sizeof q);
    if (gainproof_measure(&places[0], &places[1], &q, &places[2], &m) == GAINPROOF_OK)
        check(all_finite(data, sizeof places + sizeof q) && all_finite(&m, sizeof m));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size >= sizeof(gainproof_measurement)) {
        measure(data);
        cascade(data, size);
        attitude(data, size);
    }
    return 0;
}
