"""The header of the exported C: what a firmware engineer reads first."""

from plant.backends.c_code import REALS, literal
from plant.backends.c_records import CRecords
from tuner.exchange.texts import c_comment, c_string, tool
from tuner.gains import Controller

HEADER = """\
/* {p}_controller.h: flight controller of {title}, written by {tool}.

   airframe      {airframe}
   laws          position {position}, attitude {attitude}
   period        {period} s; the constants hold for this period alone
   arithmetic    {real}
   gains         {digest}

   Frames: world ENU (x east, y north, z up), body FLU (x forward, y left, z up). Angles roll, pitch, yaw [rad] of
   R = Rz(yaw) Ry(pitch) Rx(roll), positive pitch is nose down. Units: m, s, rad, N, N m.

   No globals, no heap, no recursion; the caller owns all state. Nothing is called but sqrt{suffix}, fabs{suffix} and memcpy.
   Compile with -ffp-contract=off to have the bits of the golden vectors, as C99 or as C++; -ffast-math is refused.

   An input that is infinite or NaN, or so large that what follows from it is, is refused: the status says so, the state is as
   it was and the output is the last good one, after an init that of hover. So finite states stay finite whatever comes in. */

#ifndef {P}_CONTROLLER_H
#define {P}_CONTROLLER_H

#ifdef __cplusplus
extern "C" {{
#endif

#define {P}_PERIOD {period_literal} /* [s] */
#define {P}_MASS {mass} /* [kg] */
#define {P}_AIRFRAME {airframe_text}
#define {P}_POSITION_LAW "{position}"
#define {P}_ATTITUDE_LAW "{attitude}"
#define {P}_GAINS_DIGEST {digest_text}

typedef {real} {p}_real;

typedef enum {{
    {P}_OK = 0,
    {P}_REFUSED = 1 /* something was infinite or NaN, or a quaternion far from unit length */
}} {p}_status;

typedef struct {{
    {p}_real x, y, z;
}} {p}_vec3;

/* Rotates body into world coordinates; |q|^2 within 0.99 and 1.01. */
typedef struct {{
    {p}_real w, x, y, z;
}} {p}_quaternion;

/* What the vehicle is asked to do. hold is 1 where position is tracked, and 0 in attitude mode: roll and pitch are then
   tracked as given, x and y are free, and altitude is still held. */
typedef struct {{
    {p}_vec3 position;     /* world [m] */
    {p}_vec3 velocity;     /* world [m/s] */
    {p}_vec3 acceleration; /* world [m/s2] */
    {p}_real roll, pitch;  /* [rad], read in attitude mode */
    {p}_real yaw;          /* [rad], met the short way round */
    {p}_real yaw_rate;     /* [rad/s] */
    {p}_real hold;         /* 1 or 0 */
}} {p}_reference;

/* The vehicle as measured; {p}_measure fills it from a quaternion. */
typedef struct {{
    {p}_vec3 position;         /* world [m] */
    {p}_vec3 velocity;         /* world [m/s] */
    {p}_vec3 angles;           /* roll, pitch, yaw [rad]; yaw may jump by whole turns */
    {p}_vec3 rate;             /* gyro, body [rad/s] */
    {p}_vec3 thrust_direction; /* body z axis in world coordinates */
    {p}_vec3 heading;          /* (cos yaw, sin yaw, 0) */
}} {p}_measurement;

/* What the rotors are to do now. Rotors: 1 front left, 2 front right, 3 rear left, 4 rear right; in a plus frame 1 front,
   2 right, 3 left, 4 rear. */
typedef struct {{
    {p}_real rotor_thrust[4]; /* within the limits of the rotors [N] */
    {p}_real thrust;          /* sum of the rotor thrusts [N] */
    {p}_vec3 torque;          /* torque of the rotor thrusts, body [N m] */
}} {p}_command;

typedef struct {{
    {p}_real roll, pitch; /* [rad] */
    {p}_real yaw;         /* [rad], met the short way round */
    {p}_real yaw_rate;    /* [rad/s] */
}} {p}_attitude_setpoint;

typedef struct {{
    {p}_vec3 angles; /* roll, pitch, yaw [rad]; yaw may jump by whole turns */
    {p}_vec3 rate;   /* gyro, body [rad/s] */
}} {p}_attitude_measurement;

/* What became of the last torques, body. Without limits and lag: effect the torque of the last step, excess 0. */
typedef struct {{
    {p}_vec3 effect; /* mean torque that the rotors delivered over the last period, as far as known [N m] */
    {p}_vec3 excess; /* last torque after limits minus the torque asked for [N m] */
}} {p}_attitude_applied;

/* States: their members are nobody's business but a debugger's. */
{typedefs}

typedef struct {{
    {memory} control;
    {p}_rotors in_force, pending; /* rotor thrusts of this period and, with compute delay, of the next [N] */
    {p}_command command;          /* the last good output */
}} {p}_state;

typedef struct {{
    {loop_memory} roll, pitch, yaw;
    {p}_real yaw_seen;   /* yaw, counted on through whole turns [rad] */
    {p}_real yaw_torque; /* behind its low-pass [N m] */
    {p}_vec3 torque;     /* the last good output [N m] */
}} {p}_attitude_state;

/* Fills a measurement from an attitude quaternion; refused, and left as it is, where the nose points straight up or down. */
{p}_status {p}_measure(const {p}_vec3 *position, const {p}_vec3 *velocity, const {p}_quaternion *attitude,
    const {p}_vec3 *rate, {p}_measurement *m);

/* The whole cascade. init: at rest at the measurement, rotors at hover; again after every pause. A state that was never
   initialised without being refused must not be stepped. step: once every period. */
{p}_status {p}_init({p}_state *state, const {p}_measurement *m);
{p}_status {p}_step({p}_state *state, const {p}_reference *reference, const {p}_measurement *m, {p}_command *command);

/* The three attitude loops alone, for a vehicle that allocates torque itself. */
{p}_status {p}_attitude_init({p}_attitude_state *state, const {p}_attitude_measurement *m);
{p}_status {p}_attitude_step({p}_attitude_state *state, const {p}_attitude_setpoint *setpoint,
    const {p}_attitude_measurement *m, const {p}_attitude_applied *applied, {p}_vec3 *torque);

#ifdef __cplusplus
}}
#endif

#endif
"""


def header_text(controller: Controller, real: str, prefix: str, digest: str, records: CRecords) -> str:
    """Write the header; records: the types of all states are among them."""
    kind = REALS[real]
    cascade = controller.cascade
    return HEADER.format(
        p=prefix,
        P=prefix.upper(),
        tool=tool(),
        title=c_comment(controller.airframe.title),
        airframe=c_comment(controller.airframe.name),
        position=cascade.position.name,
        attitude=cascade.attitude.name,
        period=f"{controller.control_period:.9g}",
        period_literal=literal(controller.control_period, kind),
        mass=literal(controller.airframe.vehicle.mass, kind),
        real=real,
        suffix=kind.suffix,
        digest=c_comment(digest),
        airframe_text=c_string(controller.airframe.name),
        digest_text=c_string(digest),
        typedefs="\n\n".join(records.typedefs),
        memory=records.name(cascade.Memory),
        loop_memory=records.name(cascade.attitude.Memory),
    )
