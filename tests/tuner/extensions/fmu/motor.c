/* A DC motor as an FMU for co-simulation, FMI 2.0 or 3.0, for tests: equations and Runge-Kutta steps as plants in Python have them.

   -DFMI=2 or 3. It misbehaves once the angle [rad] has passed the parameter `fault`, where that is above 0: -DFAULT=CRASH, HANG,
   NOT_A_NUMBER or AN_ERROR. -DHIDDEN adds a lag of the voltage of which its description says nothing; -DMOVING starts it at
   1 rad/s; -DNO_SLOPE has it refuse the directional derivatives that it promises. */

#include <math.h>
#include <stdint.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>


enum { CRASH = 1, HANG, NOT_A_NUMBER, AN_ERROR };
#ifndef FAULT
#define FAULT 0
#endif

enum { ANGLE, SPEED, ANGLE_RATE, ACCELERATION, VOLTAGE, TORQUE, INERTIA, FRICTION, CONSTANT, RESISTANCE, FAULT_ANGLE, COUNT };
enum { OK = 0, ERROR = 3 };

typedef struct {
    double v[COUNT];
    double lagged;
} Motor;

static const double START[COUNT] = {[INERTIA] = 3.2284e-6, [FRICTION] = 3.5077e-6, [CONSTANT] = 0.0274, [RESISTANCE] = 4.0};

static void begin(Motor *m)
{
    memcpy(m->v, START, sizeof START);
    m->lagged = 0.0;
#ifdef MOVING
    m->v[SPEED] = 1.0;
#endif
}

static void rates(const Motor *m, double speed, double voltage, double *out)
{
    double current = (voltage - m->v[CONSTANT] * speed) / m->v[RESISTANCE];
    double torque = m->v[CONSTANT] * current - m->v[FRICTION] * speed + m->v[TORQUE];
    out[0] = speed;
    out[1] = torque / m->v[INERTIA];
}

static int step(Motor *m, double h)
{
    double k[4][2], *x = &m->v[ANGLE], voltage = m->v[VOLTAGE];
#ifdef HIDDEN
    m->lagged += (voltage - m->lagged) * (1.0 - exp(-h / 0.005));
    voltage = m->lagged;
#endif
    rates(m, x[1], voltage, k[0]);
    rates(m, x[1] + 0.5 * h * k[0][1], voltage, k[1]);
    rates(m, x[1] + 0.5 * h * k[1][1], voltage, k[2]);
    rates(m, x[1] + h * k[2][1], voltage, k[3]);
    for (int i = 0; i < 2; i++)
        x[i] += h / 6.0 * (k[0][i] + 2.0 * k[1][i] + 2.0 * k[2][i] + k[3][i]);
    if (m->v[FAULT_ANGLE] > 0.0 && x[0] > m->v[FAULT_ANGLE]) {
        if (FAULT == CRASH) abort();
        if (FAULT == HANG) for (;;) sleep(1);
        if (FAULT == NOT_A_NUMBER) x[0] = NAN;
        if (FAULT == AN_ERROR) return ERROR;
    }
    return OK;
}

static int get(Motor *m, const unsigned *reference, size_t n, double *value)
{
    for (size_t i = 0; i < n; i++) {
        if (reference[i] >= COUNT) return ERROR;
        value[i] = m->v[reference[i]];
    }
    return OK;
}

static int set(Motor *m, const unsigned *reference, size_t n, const double *value)
{
    for (size_t i = 0; i < n; i++) {
        if (reference[i] >= COUNT) return ERROR;
        m->v[reference[i]] = value[i];
    }
    return OK;
}

/* Derivatives of the rates and of the angle by angle, speed and voltage, in closed form. */
static int slope(Motor *m, const unsigned *unknown, size_t unknowns, const unsigned *known, size_t knowns, const double *seed, double *out)
{
#ifdef NO_SLOPE
    return ERROR;
#endif
    double c = m->v[CONSTANT], r = m->v[RESISTANCE], j = m->v[INERTIA];
    for (size_t i = 0; i < unknowns; i++) {
        out[i] = 0.0;
        for (size_t k = 0; k < knowns; k++) {
            double by = 0.0;
            if (unknown[i] == ANGLE && known[k] == ANGLE) by = 1.0;
            if (unknown[i] == ANGLE_RATE && known[k] == SPEED) by = 1.0;
            if (unknown[i] == ACCELERATION && known[k] == SPEED) by = (-c * c / r - m->v[FRICTION]) / j;
            if (unknown[i] == ACCELERATION && known[k] == VOLTAGE) by = c / r / j;
            out[i] += by * seed[k];
        }
    }
    return OK;
}

static void *made(void)
{
    Motor *m = malloc(sizeof *m);
    begin(m);
    return m;
}

#if FMI == 2
void *fmi2Instantiate(const char *n, int kind, const char *guid, const char *r, const void *f, int v, int l)
{
    return kind == 1 && !strcmp(guid, "motor-token") ? made() : NULL;
}
void fmi2FreeInstance(void *m) { free(m); }
int fmi2SetupExperiment(void *m, int t, double tol, double start, int s, double stop) { return OK; }
int fmi2EnterInitializationMode(void *m) { return OK; }
int fmi2ExitInitializationMode(void *m) { return OK; }
int fmi2Reset(void *m) { begin(m); return OK; }
int fmi2GetReal(void *m, const unsigned *r, size_t n, double *v) { return get(m, r, n, v); }
int fmi2SetReal(void *m, const unsigned *r, size_t n, const double *v) { return set(m, r, n, v); }
int fmi2DoStep(void *m, double t, double h, int again) { return step(m, h); }
int fmi2GetDirectionalDerivative(void *m, const unsigned *u, size_t nu, const unsigned *k, size_t nk, const double *seed, double *out)
{
    return slope(m, u, nu, k, nk, seed, out);
}
#else
void *fmi3InstantiateCoSimulation(const char *n, const char *token, const char *r, bool v, bool l, bool e, bool early,
                                  const unsigned *needed, size_t count, void *world, void *log, void *update)
{
    return strcmp(token, "motor-token") ? NULL : made();
}
void fmi3FreeInstance(void *m) { free(m); }
int fmi3EnterInitializationMode(void *m, bool t, double tol, double start, bool s, double stop) { return OK; }
int fmi3ExitInitializationMode(void *m) { return OK; }
int fmi3Reset(void *m) { begin(m); return OK; }
int fmi3GetFloat64(void *m, const unsigned *r, size_t n, double *v, size_t nv) { return get(m, r, n, v); }
int fmi3SetFloat64(void *m, const unsigned *r, size_t n, const double *v, size_t nv) { return set(m, r, n, v); }
int fmi3DoStep(void *m, double t, double h, bool again, bool *event, bool *end, bool *early, double *last)
{
    *event = *end = *early = false;
    *last = t + h;
    return step(m, h);
}
int fmi3GetDirectionalDerivative(void *m, const unsigned *u, size_t nu, const unsigned *k, size_t nk, const double *seed, size_t ns,
                                 double *out, size_t no)
{
    return slope(m, u, nu, k, nk, seed, out);
}
#endif
