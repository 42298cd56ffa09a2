/* The closed loop of `benchmarks.course` by hand in C: how fast these flights could be on this machine.
 *
 * Hybrid law in all six channels, rigid body with rotor lag, RK4, wind and sensor noise read every period, all meters of
 * `objectives/meters.py`. Structure of arrays, LANES flights side by side; `run` flies whole candidates and may be called from many threads.
 *
 * Left out, against the package: options that this course does not use (rates from the observer, compute delay, lag-blind observers,
 * attitude mode, gust rates and injected accelerations); everything else is the same work and the same meters.
 * SHORTCUTS=1 adds what only a hand knows about this very course: rotors of first order have closed-form Runge-Kutta stages over a
 * held command, masses and lever arms are multiplied out once a flight, and axes without a step need no crossing times.
 *
 * Built with -O3 -march=native -ffast-math -fno-finite-math-only (a diverged flight must be noticed) -fopenmp-simd; threads are the caller's.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#ifndef LANES
#define LANES 16
#endif
#ifndef SHORTCUTS
#define SHORTCUTS 0
#endif
#define INLINE static inline __attribute__((always_inline))
#ifdef __clang__
#define SIMD _Pragma("clang loop vectorize(assume_safety)")
#else
#define SIMD _Pragma("omp simd")
#endif
#define EACH_LANE SIMD for (int l = 0; l < LANES; l++)

typedef struct { double x, y, z; } Vec;
typedef struct { double w, x, y, z; } Quat;
typedef struct { double a, b, c, d; } Four;
typedef struct { Vec p, v; Quat q; Vec w; Four r; } Body;

/* Leaves of plant.quadrotor.nominal.Nominal that this course uses, see `known` in ceiling.py. */
typedef struct {
    double mass; Vec inertia; Four arm_x, arm_y, spin;
    double k_f, ratio, rotor_inertia, lag_up, lag_down, speed_min, speed_max;
    Vec drag1, drag2; double drag_height; Vec damping; double gravity;
    Four to_thrust, to_roll, to_pitch, to_yaw, reach;
    double hover, low, high, lag_step, lag_missing, tangent, options[4], smoothing;
} Nominal;
typedef struct { double start, final, time, band, recovery_from, recovery_band, steady_from; } Target;
typedef struct { double omega_o, lambda, k1, k2, delta; } Gains;
typedef struct { double l1, l2, l3, lambda, k1, k2, per_delta; } Law;
typedef struct { Vec p, v, a; double roll, pitch, yaw, yaw_rate, hold; } Reference;

/* Rows of a block of flights. */
enum { P, V = P + 3, Q = V + 3, W = Q + 4, R = W + 3, SPEED = R + 4, FORCE = SPEED + 4, THRUST = FORCE + 4, Z = THRUST + 4,
       SEEN = Z + 18, TWIST, METER, TOTALS = METER + 66, STATUS = TOTALS + 4, END, ROWS };
/* Rows of plant.quadrotor.rigid_body.Dynamics. */
enum { I_MASS, I_INERTIA, COUPLING = I_INERTIA + 3, ARM_X = COUPLING + 3, ARM_Y = ARM_X + 4, SPIN = ARM_Y + 4, K_F = SPIN + 4,
       RATIO, J_ROTOR, RISE, FALL, DRAG1, DRAG2 = DRAG1 + 3, HEIGHT = DRAG2 + 3, DAMPING, GRAVITY = DAMPING + 3, DYNAMICS };
enum { RESULTS = 66 + 4 + 2, NOISES = 12, WINDS = 3 };

INLINE double least(double a, double b) { return a < b ? a : b; }
INLINE double most(double a, double b) { return a > b ? a : b; }
INLINE double within(double a, double low, double high) { return least(most(a, low), high); }

INLINE double angle_of(double y, double x) {
    double ax = fabs(x), ay = fabs(y), s = least(ax, ay), g = most(most(ax, ay), 1e-300);
    int large = s > 0.41421356237309503 * g;
    double r = (large ? s - g : s) / (large ? s + g : g), z = r * r;
    double n = (((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z - 7.500855792314704667340e1) * z
                - 1.228866684490136173410e2) * z - 6.485021904942025371773e1;
    double d = ((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z + 4.328810604912902668951e2) * z
                + 4.853903996359136964868e2) * z + 1.945506571482613964425e2;
    double t = (large ? 0.7853981633974483 : 0.0) + r + r * z * n / d;
    t = ay > ax ? 1.5707963267948966 - t : t;
    t = x < 0.0 ? 3.141592653589793 - t : t;
    return y < 0.0 ? -t : t;
}
INLINE double nearest(double angle, double goal) {
    return angle - 6.283185307179586 * floor((angle - goal) * 0.15915494309189535 + 0.5);
}
INLINE Vec cross(Vec a, Vec b) { return (Vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
INLINE Vec turned(Quat q, Vec a) {
    Vec u = {q.x, q.y, q.z}, t = cross(u, a), s = cross(u, t);
    double w = 2.0 * q.w;
    return (Vec){a.x + w * t.x + 2.0 * s.x, a.y + w * t.y + 2.0 * s.y, a.z + w * t.z + 2.0 * s.z};
}
INLINE double dot4(Four a, Four b) { return a.a * b.a + a.b * b.b + a.c * b.c + a.d * b.d; }
INLINE double sum4(Four a) { return a.a + a.b + a.c + a.d; }
INLINE Four axpy4(Four a, double s, Four b) { return (Four){a.a + s * b.a, a.b + s * b.b, a.c + s * b.c, a.d + s * b.d}; }
INLINE Vec axpy3(Vec a, double s, Vec b) { return (Vec){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z}; }
INLINE Quat axpyq(Quat a, double s, Quat b) { return (Quat){a.w + s * b.w, a.x + s * b.x, a.y + s * b.y, a.z + s * b.z}; }

#define VEC(s, row) ((Vec){(s)[row][l], (s)[(row) + 1][l], (s)[(row) + 2][l]})
#define QUAT(s, row) ((Quat){(s)[row][l], (s)[(row) + 1][l], (s)[(row) + 2][l], (s)[(row) + 3][l]})
#define FOUR(s, row) ((Four){(s)[row][l], (s)[(row) + 1][l], (s)[(row) + 2][l], (s)[(row) + 3][l]})
#define PUT_VEC(s, row, e) do { Vec t_ = (e); (s)[row][l] = t_.x; (s)[(row) + 1][l] = t_.y; (s)[(row) + 2][l] = t_.z; } while (0)
#define PUT_QUAT(s, row, e) do { Quat t_ = (e); (s)[row][l] = t_.w; (s)[(row) + 1][l] = t_.x; (s)[(row) + 2][l] = t_.y; \
                                 (s)[(row) + 3][l] = t_.z; } while (0)
#define PUT_FOUR(s, row, e) do { Four t_ = (e); (s)[row][l] = t_.a; (s)[(row) + 1][l] = t_.b; (s)[(row) + 2][l] = t_.c; \
                                 (s)[(row) + 3][l] = t_.d; } while (0)

static Law sampled(const Gains *g, double h) {
    double beta = exp(-g->omega_o * h), gap = 1.0 - beta;
    return (Law){1.0 - beta * beta * beta, 1.5 * gap * gap * (1.0 + beta) / h, gap * gap * gap / (h * h),
                 g->lambda, g->k1, g->k2, 1.0 / g->delta};
}

/* One hybrid channel: returns the demanded acceleration of y and writes the observer back. */
INLINE double channel(double z[restrict][LANES], int l, Law c, double goal, double goal_rate, double push, double y, double rate,
                      double acceleration, double h) {
    double drift = z[2][l] + acceleration, ahead = z[0][l] + h * z[1][l] + 0.5 * h * h * drift, miss = y - ahead;
    double rate_error = rate - goal_rate, s = rate_error + c.lambda * (y - goal);
    double z3 = z[2][l] + c.l3 * miss;
    z[1][l] = z[1][l] + h * drift + c.l2 * miss;
    z[0][l] = ahead + c.l1 * miss;
    z[2][l] = z3;
    double slide = c.k1 * sqrt(fabs(s)) * within(s * c.per_delta, -1.0, 1.0) + c.k2 * s;
    return push - c.lambda * rate_error - slide - z3;
}

/* Comparisons as 0.0 or 1.0 and conditions joined without branches: what has a branch in it is not vectorised. */
INLINE double either_of(int condition, double a, double b) { return condition ? a : b; }

INLINE double crossing(double latched, double level, double before, double now, int since, double moment, double t, double h) {
    int rising = before < level, there = level <= now;
    double over = either_of(rising & there, now - before, 1.0);
    double ago = either_of(rising, (now - level) / over, 1.0);
    return either_of((latched < 0.0) & since & there, most(t - h * ago, moment), latched);
}

/* What an axis's meter needs that all lanes share. */
typedef struct { double start, final, direction, low, high, time, band, recovery_band; int stepped, calm, steady, flat; } Goal;

static Goal goal_of(Target g, double t, double h) {
    double change = g.final - g.start, step = fabs(change), early = 1e-6 * h;
    return (Goal){g.start, g.final, (change > 0.0) - (change < 0.0), 0.1 * step, 0.9 * step, g.time, g.band, g.recovery_band,
                  t >= g.time - early, t >= g.recovery_from - early, t >= g.steady_from - early, step == 0.0};
}

/* One axis's meter, kept as it is where the flight is over. */
INLINE void meter(double m[restrict][LANES], int l, int alive, Goal g, double goal, double actual, double t, double h) {
    double m3 = m[3][l], m4 = m[4][l], m5 = m[5][l], m6 = m[6][l], m7 = m[7][l], m8 = m[8][l], m9 = m[9][l];
    double e = goal - actual, size = fabs(e), now = (actual - g.start) * g.direction, live = either_of(alive, h, 0.0);
    m[0][l] += live * t * size;
    m[1][l] += live * size;
    m[2][l] += live * e * e;
    m[3][l] = either_of(alive, most(m3, size), m3);
    m[4][l] = either_of(alive & g.stepped, most(m4, (actual - g.final) * g.direction), m4);
    double before = (m7 - g.start) * g.direction;
    m[5][l] = either_of(alive, crossing(m5, g.low, before, now, g.stepped, g.time, t, h), m5);
    m[6][l] = either_of(alive, crossing(m6, g.high, before, now, g.stepped, g.time, t, h), m6);
    m[7][l] = either_of(alive, actual, m7);
    m[8][l] = either_of(alive & g.stepped & (size > g.band), t + h, m8);
    m[9][l] = either_of(alive & g.calm & (size > g.recovery_band), t + h, m9);
    m[10][l] += either_of(g.steady, live * e, 0.0);
}

/* The same for an axis without a step: it has crossed its levels as soon as the time of the step has come. */
INLINE void flat_meter(double m[restrict][LANES], int l, int alive, Goal g, double goal, double actual, double t, double h) {
    double m3 = m[3][l], m5 = m[5][l], m7 = m[7][l], m8 = m[8][l], m9 = m[9][l];
    double e = goal - actual, size = fabs(e), live = either_of(alive, h, 0.0);
    m[0][l] += live * t * size;
    m[1][l] += live * size;
    m[2][l] += live * e * e;
    m[3][l] = either_of(alive, most(m3, size), m3);
    m5 = either_of(alive & g.stepped & (m5 < 0.0), most(t - h, g.time), m5);
    m[5][l] = m5;
    m[6][l] = m5;
    m[7][l] = either_of(alive, actual, m7);
    m[8][l] = either_of(alive & g.stepped & (size > g.band), t + h, m8);
    m[9][l] = either_of(alive & g.calm & (size > g.recovery_band), t + h, m9);
    m[10][l] += either_of(g.steady, live * e, 0.0);
}

INLINE double room(double base, double extra, double low, double high) { return extra > 0.0 ? high - base : base - low; }

INLINE Vec torque_of(Four thrust, const Nominal *n) {
    return (Vec){dot4(n->arm_y, thrust), -dot4(n->arm_x, thrust), n->ratio * dot4(n->spin, thrust)};
}

/* Sense, decide, judge: one control instant of one lane. */
INLINE void decide(double s[restrict ROWS][LANES], int l, const double noise[restrict NOISES][LANES], const Law law[6],
                   const Nominal *n, const Reference *ref, const double limits[2], double t, double h,
                   double shown[restrict 8][LANES]) {
    Vec p = VEC(s, P), v = VEC(s, V), w = VEC(s, W);
    Quat q = QUAT(s, Q);
    double xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
    double sine = within(2.0 * (q.w * q.y - q.z * q.x), -1.0, 1.0);
    Vec angles = {angle_of(2.0 * (q.w * q.x + q.y * q.z), 1.0 - 2.0 * (xx + yy)),
                  angle_of(sine, sqrt(most((1.0 - sine) * (1.0 + sine), 0.0))),
                  angle_of(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (yy + zz))};
    Vec level = {2.0 * (q.x * q.z + q.w * q.y), 2.0 * (q.y * q.z - q.w * q.x), 1.0 - 2.0 * (xx + yy)};
    double cx = 1.0 - 2.0 * (yy + zz), cy = 2.0 * (q.w * q.z + q.x * q.y), norm = 1.0 / sqrt(cx * cx + cy * cy);
    Vec slant = VEC(noise, 6);
    Vec direction = axpy3(level, 1.0, turned(q, (Vec){slant.y, -slant.x, 0.0}));
    double head_x = norm * (cx - slant.z * cy), head_y = norm * (cy + slant.z * cx);
    Vec mp = axpy3(p, 1.0, VEC(noise, 0)), mv = axpy3(v, 1.0, VEC(noise, 3));
    Vec ma = axpy3(angles, 1.0, slant), mw = axpy3(w, 1.0, VEC(noise, 9));

    Four force = FOUR(s, FORCE), model = FOUR(s, THRUST);
    Four lagging = axpy4(force, -1.0, model), average = axpy4(force, -n->lag_missing, lagging);
    PUT_FOUR(s, THRUST, axpy4(model, n->lag_step, lagging));
    double lift = sum4(average) / n->mass, g = n->gravity;
    Vec felt = {lift * direction.x, lift * direction.y, lift * direction.z - g}, torque_felt = torque_of(average, n);

    double ux = channel(s + Z, l, law[0], ref->p.x, ref->v.x, ref->a.x, mp.x, mv.x, felt.x, h);
    double uy = channel(s + Z + 3, l, law[1], ref->p.y, ref->v.y, ref->a.y, mp.y, mv.y, felt.y, h);
    double uz = channel(s + Z + 6, l, law[2], ref->p.z, ref->v.z, ref->a.z, mp.z, mv.z, felt.z, h);
    double up = most(uz, -0.8 * g) + g;
    double scale = least(1.0, n->tangent * up / sqrt(ux * ux + uy * uy + 1e-12));
    ux *= scale;
    uy *= scale;
    double ahead = head_x * ux + head_y * uy, left = head_x * uy - head_y * ux;
    double roll = angle_of(-left, sqrt(ahead * ahead + up * up)), pitch = angle_of(ahead, up);
    double yaw_now = nearest(ma.z, s[SEEN][l]), yaw_goal = nearest(ref->yaw, yaw_now);
    s[SEEN][l] = yaw_now;
    Vec inverse = {1.0 / n->inertia.x, 1.0 / n->inertia.y, 1.0 / n->inertia.z};
    double tx = n->inertia.x * channel(s + Z + 9, l, law[3], roll, 0.0, 0.0, ma.x, mw.x, inverse.x * torque_felt.x, h);
    double ty = n->inertia.y * channel(s + Z + 12, l, law[4], pitch, 0.0, 0.0, ma.y, mw.y, inverse.y * torque_felt.y, h);
    double tz = n->inertia.z * channel(s + Z + 15, l, law[5], yaw_goal, ref->yaw_rate, 0.0, yaw_now, mw.z,
                                       inverse.z * torque_felt.z, h);
    tz = n->smoothing * tz + (1.0 - n->smoothing) * s[TWIST][l];
    s[TWIST][l] = tz;

    double thrust = n->mass * up / most(direction.z, 0.5);
    Four none = {0.0, 0.0, 0.0, 0.0};
    Four base = axpy4(axpy4(axpy4(none, thrust, n->to_thrust), tx, n->to_roll), ty, n->to_pitch);
    Four turn = axpy4(none, tz, n->to_yaw);
    double low = n->low, high = n->high;
    double front = least(n->reach.a * room(base.a, turn.a, low, high), n->reach.b * room(base.b, turn.b, low, high));
    double rear = least(n->reach.c * room(base.c, turn.c, low, high), n->reach.d * room(base.d, turn.d, low, high));
    double share = within(least(front, rear) / most(fabs(tz), 1e-15), 0.0, 1.0);
    Four wanted = axpy4(base, share, turn);
    Four command = {within(wanted.a, low, high), within(wanted.b, low, high), within(wanted.c, low, high),
                    within(wanted.d, low, high)};
    double per_k = 1.0 / n->k_f;
    PUT_FOUR(s, SPEED, ((Four){sqrt(command.a * per_k), sqrt(command.b * per_k), sqrt(command.c * per_k),
                               sqrt(command.d * per_k)}));
    PUT_FOUR(s, FORCE, command);

    double size = p.x * p.x + p.y * p.y + p.z * p.z + v.x * v.x + v.y * v.y + v.z * v.z + w.x * w.x + w.y * w.y + w.z * w.z;
    int near = (fabs(p.x - ref->p.x) < limits[0]) & (fabs(p.y - ref->p.y) < limits[0]) & (fabs(p.z - ref->p.z) < limits[0]);
    double status = either_of(size < 1e12, either_of(level.z > limits[1], either_of(near, 0.0, 2.0), 1.0), 3.0);
    double earlier = s[STATUS][l], end = s[END][l];
    status = either_of(earlier < 0.5, status, earlier);
    int alive = status < 0.5;
    s[STATUS][l] = status;
    s[END][l] = either_of(alive, t + h, end);

    shown[0][l] = alive ? 1.0 : 0.0;
    PUT_VEC(shown, 1, angles);
    shown[4][l] = roll;
    shown[5][l] = pitch;
    double per_hover = 1.0 / n->hover;
    Four share_now = axpy4(none, per_hover, command), change = axpy4(share_now, -per_hover, force);
    Four beyond = {share_now.a - 1.0, share_now.b - 1.0, share_now.c - 1.0, share_now.d - 1.0};
    double smallest = least(least(command.a, command.b), least(command.c, command.d));
    double largest = most(most(command.a, command.b), most(command.c, command.d)), margin = 1e-6 * (high - low);
    s[TOTALS][l] += alive ? fabs(change.a) + fabs(change.b) + fabs(change.c) + fabs(change.d) : 0.0;
    s[TOTALS + 1][l] += alive ? h * dot4(beyond, beyond) : 0.0;
    s[TOTALS + 2][l] += alive & ((smallest <= low + margin) | (largest >= high - margin)) ? h : 0.0;
    double peak = s[TOTALS + 3][l];
    s[TOTALS + 3][l] = either_of(alive, most(peak, per_hover * largest), peak);
}

/* What a lane's rigid body needs, in registers or close by. */
typedef struct {
    double inverse_mass, k_f, ratio, rotor_inertia, rise, fall, height, gravity;
    Vec inverse_inertia, coupling, drag1, drag2, damping, wind;
    Four arm_x, arm_y, spin, command;
} Frame;

typedef struct { Vec v; Quat q; Vec w; Four r; } Rate;

INLINE Rate motion(Vec v, Quat q, Vec w, Four r, const Frame *f) {
    Rate out;
    Quat back = {q.w, -q.x, -q.y, -q.z};
    Vec air = turned(back, axpy3(v, -1.0, f->wind));
    double speed = sqrt(air.x * air.x + air.y * air.y + air.z * air.z);
    Vec drag = {-(f->drag1.x + f->drag2.x * speed) * air.x, -(f->drag1.y + f->drag2.y * speed) * air.y,
                -(f->drag1.z + f->drag2.z * speed) * air.z};
    Four lift;
    if (SHORTCUTS) lift = (Four){r.a * r.a, r.b * r.b, r.c * r.c, r.d * r.d};
    else lift = (Four){f->k_f * r.a * r.a, f->k_f * r.b * r.b, f->k_f * r.c * r.c, f->k_f * r.d * r.d};
    double total = SHORTCUTS ? f->k_f * sum4(lift) : sum4(lift);
    Vec push = turned(q, (Vec){drag.x, drag.y, drag.z + total});
    Four c = f->command;
    out.r = (Four){(c.a - r.a) * (c.a > r.a ? f->rise : f->fall), (c.b - r.b) * (c.b > r.b ? f->rise : f->fall),
                   (c.c - r.c) * (c.c > r.c ? f->rise : f->fall), (c.d - r.d) * (c.d > r.d ? f->rise : f->fall)};
    double spin = -f->rotor_inertia * dot4(f->spin, r);
    double yaw = f->ratio * dot4(f->spin, lift) + f->rotor_inertia * dot4(f->spin, out.r);
    Vec torque = {dot4(f->arm_y, lift) - w.y * spin - f->height * drag.y - f->damping.x * w.x,
                  -dot4(f->arm_x, lift) + w.x * spin + f->height * drag.x - f->damping.y * w.y, yaw - f->damping.z * w.z};
    out.v = (Vec){f->inverse_mass * push.x, f->inverse_mass * push.y, f->inverse_mass * push.z - f->gravity};
    out.q = (Quat){-0.5 * (q.x * w.x + q.y * w.y + q.z * w.z), 0.5 * (q.w * w.x + q.y * w.z - q.z * w.y),
                   0.5 * (q.w * w.y - q.x * w.z + q.z * w.x), 0.5 * (q.w * w.z + q.x * w.y - q.y * w.x)};
    out.w = (Vec){f->inverse_inertia.x * torque.x - f->coupling.x * w.y * w.z,
                  f->inverse_inertia.y * torque.y - f->coupling.y * w.z * w.x,
                  f->inverse_inertia.z * torque.z - f->coupling.z * w.x * w.y};
    return out;
}

/* Rotors that approach a held command at a constant pole: error at the Runge-Kutta stages over the error at the start. */
typedef struct { Four half1, half2, full, end; } Decay;

INLINE void decay_of(double error, double rise, double fall, double h, double *h1, double *h2, double *f, double *e) {
    double a = h * (error < 0.0 ? rise : fall);
    *h1 = 1.0 - 0.5 * a;
    *h2 = 1.0 - 0.5 * a * *h1;
    *f = 1.0 - a * *h2;
    *e = 1.0 - a * (1.0 / 6.0) * (1.0 + 2.0 * *h1 + 2.0 * *h2 + *f);
}

INLINE Four relaxed(Four command, Four error, Four share) {
    return (Four){command.a + error.a * share.a, command.b + error.b * share.b, command.c + error.c * share.c,
                  command.d + error.d * share.d};
}

INLINE Quat renormalised(Quat q) {
    double s = 1.5 - 0.5 * (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    return (Quat){s * q.w, s * q.x, s * q.y, s * q.z};
}

INLINE Body fly(Body b, const Frame *f, const Decay *d, double h) {
    Four error = axpy4(b.r, -1.0, f->command), r2, r3, r4;
    Rate k1 = motion(b.v, b.q, b.w, b.r, f);
    Vec v = axpy3(b.v, 0.5 * h, k1.v), sum_v = k1.v, sum_p = k1.v;
    Quat q = axpyq(b.q, 0.5 * h, k1.q), sum_q = k1.q;
    Vec w = axpy3(b.w, 0.5 * h, k1.w), sum_w = k1.w;
    Four sum_r = k1.r;
    r2 = SHORTCUTS ? relaxed(f->command, error, d->half1) : axpy4(b.r, 0.5 * h, k1.r);
    Rate k = motion(v, q, w, r2, f);
    sum_p = axpy3(sum_p, 1.0, k.v);
    sum_v = axpy3(sum_v, 2.0, k.v), sum_q = axpyq(sum_q, 2.0, k.q), sum_w = axpy3(sum_w, 2.0, k.w);
    if (!SHORTCUTS) sum_r = axpy4(sum_r, 2.0, k.r);
    v = axpy3(b.v, 0.5 * h, k.v), q = axpyq(b.q, 0.5 * h, k.q), w = axpy3(b.w, 0.5 * h, k.w);
    r3 = SHORTCUTS ? relaxed(f->command, error, d->half2) : axpy4(b.r, 0.5 * h, k.r);
    k = motion(v, q, w, r3, f);
    sum_p = axpy3(sum_p, 1.0, k.v);
    sum_v = axpy3(sum_v, 2.0, k.v), sum_q = axpyq(sum_q, 2.0, k.q), sum_w = axpy3(sum_w, 2.0, k.w);
    if (!SHORTCUTS) sum_r = axpy4(sum_r, 2.0, k.r);
    v = axpy3(b.v, h, k.v), q = axpyq(b.q, h, k.q), w = axpy3(b.w, h, k.w);
    r4 = SHORTCUTS ? relaxed(f->command, error, d->full) : axpy4(b.r, h, k.r);
    k = motion(v, q, w, r4, f);
    if (!SHORTCUTS) sum_r = axpy4(sum_r, 1.0, k.r);
    double sixth = h / 6.0;
    Body out;
    /* The position has no part in the dynamics: its four stages add up to h v + h^2/6 (a1 + a2 + a3). */
    out.p = axpy3(axpy3(b.p, h, b.v), h * sixth, sum_p);
    out.v = axpy3(b.v, sixth, axpy3(sum_v, 1.0, k.v));
    out.q = renormalised(axpyq(b.q, sixth, axpyq(sum_q, 1.0, k.q)));
    out.w = axpy3(b.w, sixth, axpy3(sum_w, 1.0, k.w));
    out.r = SHORTCUTS ? relaxed(f->command, error, d->end) : axpy4(b.r, sixth, sum_r);
    return out;
}

INLINE Frame frame_of(const double c[restrict DYNAMICS][LANES], const double wind[restrict WINDS][LANES],
                      const double s[restrict ROWS][LANES], int l) {
    Frame f = {c[I_MASS][l], c[K_F][l], c[RATIO][l], c[J_ROTOR][l], c[RISE][l], c[FALL][l], c[HEIGHT][l], c[GRAVITY][l],
               VEC(c, I_INERTIA), VEC(c, COUPLING), VEC(c, DRAG1), VEC(c, DRAG2), VEC(c, DAMPING), VEC(wind, 0),
               FOUR(c, ARM_X), FOUR(c, ARM_Y), FOUR(c, SPIN), FOUR(s, SPEED)};
    return f;
}

#ifndef SUBSTEPS_IN_REGISTERS
#define SUBSTEPS_IN_REGISTERS 0
#endif

INLINE void one_step(double s[restrict ROWS][LANES], const double c[restrict DYNAMICS][LANES],
                     const double wind[restrict WINDS][LANES], int l, double plant_step, int times) {
    Frame f = frame_of(c, wind, s, l);
    Body b = {VEC(s, P), VEC(s, V), QUAT(s, Q), VEC(s, W), FOUR(s, R)};
    Decay d;
    if (SHORTCUTS) {
        Four error = axpy4(b.r, -1.0, f.command);
        decay_of(error.a, f.rise, f.fall, plant_step, &d.half1.a, &d.half2.a, &d.full.a, &d.end.a);
        decay_of(error.b, f.rise, f.fall, plant_step, &d.half1.b, &d.half2.b, &d.full.b, &d.end.b);
        decay_of(error.c, f.rise, f.fall, plant_step, &d.half1.c, &d.half2.c, &d.full.c, &d.end.c);
        decay_of(error.d, f.rise, f.fall, plant_step, &d.half1.d, &d.half2.d, &d.full.d, &d.end.d);
    }
    b = fly(b, &f, &d, plant_step);
    if (times == 4) {
        b = fly(b, &f, &d, plant_step);
        b = fly(b, &f, &d, plant_step);
        b = fly(b, &f, &d, plant_step);
    }
    PUT_VEC(s, P, b.p);
    PUT_VEC(s, V, b.v);
    PUT_QUAT(s, Q, b.q);
    PUT_VEC(s, W, b.w);
    PUT_FOUR(s, R, b.r);
}

static void advance(double s[restrict ROWS][LANES], const double c[restrict DYNAMICS][LANES],
                    const double wind[restrict WINDS][LANES], double plant_step, int substeps) {
    if (SUBSTEPS_IN_REGISTERS && substeps == 4) {
        EACH_LANE one_step(s, c, wind, l, plant_step, 4);
    } else {
        for (int j = 0; j < substeps; j++) EACH_LANE one_step(s, c, wind, l, plant_step, 1);
    }
}

/* Axis by axis: how a lane is judged; true angles and the tilt that was asked for come from `decide`. */
static void judge(double s[restrict ROWS][LANES], const double shown[restrict 8][LANES], const Reference *ref,
                  const Target target[6], double t, double h) {
    const double goals[6] = {ref->p.x, ref->p.y, ref->p.z, 0.0, 0.0, ref->yaw};
    for (int axis = 0; axis < 6; axis++) {
        Goal g = goal_of(target[axis], t, h);
        double(*restrict m)[LANES] = s + METER + 11 * axis;
        double actual[LANES], goal[LANES];
        EACH_LANE actual[l] = axis < 3 ? s[P + axis][l] : shown[axis - 2][l];
        EACH_LANE goal[l] = axis == 3 || axis == 4 ? shown[axis + 1][l] : goals[axis];
        if (axis == 5) EACH_LANE actual[l] = nearest(actual[l], ref->yaw);
        if (SHORTCUTS && g.flat) EACH_LANE flat_meter(m, l, shown[0][l] > 0.5, g, goal[l], actual[l], t, h);
        else EACH_LANE meter(m, l, shown[0][l] > 0.5, g, goal[l], actual[l], t, h);
    }
}

static void control(double s[restrict ROWS][LANES], const double noise[restrict NOISES][LANES], const Law law[6],
                    const Nominal *nominal, const Reference *reference, const double limits[2], double t, double h,
                    double shown[restrict 8][LANES]) {
    Nominal n = *nominal;
    Reference ref = *reference;
    EACH_LANE decide(s, l, noise, law, &n, &ref, limits, t, h, shown);
}

static void begin(double s[restrict ROWS][LANES], const double noise[restrict NOISES][LANES], const Nominal *n,
                  const Reference *ref, const Target target[6]) {
    memset(s, 0, sizeof(double) * ROWS * LANES);
    double speed = sqrt(n->hover / n->k_f);
    const double start[6] = {ref->p.x, ref->p.y, ref->p.z, 0.0, 0.0, 0.0};
    for (int l = 0; l < LANES; l++) {
        PUT_VEC(s, P, ref->p);
        s[Q][l] = 1.0;
        for (int i = 0; i < 4; i++) s[R + i][l] = s[SPEED + i][l] = speed, s[FORCE + i][l] = s[THRUST + i][l] = n->hover;
        for (int i = 0; i < 3; i++) {
            s[Z + 3 * i][l] = start[i] + noise[i][l], s[Z + 3 * i + 1][l] = noise[3 + i][l];
            s[Z + 9 + 3 * i][l] = noise[6 + i][l], s[Z + 10 + 3 * i][l] = noise[9 + i][l];
        }
        s[SEEN][l] = noise[8][l];
        for (int i = 0; i < 6; i++) {
            s[METER + 11 * i + 5][l] = s[METER + 11 * i + 6][l] = -1.0;
            s[METER + 11 * i + 7][l] = start[i];
            s[METER + 11 * i + 8][l] = target[i].time, s[METER + 11 * i + 9][l] = target[i].recovery_from;
        }
    }
}

/* gains (candidates, 30), dynamics (blocks, 35, L), winds (blocks, K, 3, L), noises (blocks, K, 12, L), references (K, 14),
 * out (candidates, blocks, 72, L). */
void run(const double *gains, const double *nominal, const double *dynamics, const double *winds, const double *noises,
         const double *references, const double *targets, const double *limits, double h, double plant_step, int substeps,
         int candidates, int blocks, int periods, double *out) {
    for (int i = 0; i < candidates * blocks; i++) {
        int candidate = i / blocks, block = i % blocks;
        const Nominal *n = (const Nominal *)nominal;
        const Reference *ref = (const Reference *)references;
        const Target *target = (const Target *)targets;
        const double(*constants)[LANES] = (const void *)(dynamics + (size_t)block * DYNAMICS * LANES);
        double own[DYNAMICS][LANES] __attribute__((aligned(64))), s[ROWS][LANES] __attribute__((aligned(64)));
        double air[WINDS][LANES] __attribute__((aligned(64))), errors[NOISES][LANES] __attribute__((aligned(64)));
        double shown[8][LANES] __attribute__((aligned(64)));
        Law law[6];
        for (int axis = 0; axis < 6; axis++) law[axis] = sampled((const Gains *)gains + 6 * candidate + axis, h);
        memcpy(own, constants, sizeof own);
        if (SHORTCUTS)
            for (int l = 0; l < LANES; l++) {
                for (int r = 0; r < 4; r++) own[ARM_X + r][l] *= own[K_F][l], own[ARM_Y + r][l] *= own[K_F][l];
                own[RATIO][l] *= own[K_F][l];
            }
        begin(s, (const void *)(noises + (size_t)block * periods * NOISES * LANES), n, ref, target);
        for (int k = 0; k < periods; k++) {
            size_t at = (size_t)block * periods + k;
            memcpy(errors, noises + at * NOISES * LANES, sizeof errors);
            memcpy(air, winds + at * WINDS * LANES, sizeof air);
            control(s, errors, law, n, ref + k, limits, k * h, h, shown);
            judge(s, shown, ref + k, target, k * h, h);
            advance(s, own, air, plant_step, substeps);
        }
        memcpy(out + (size_t)i * RESULTS * LANES, s + METER, sizeof(double) * RESULTS * LANES);
    }
}
