"""Golden vectors as a C header, and the program that holds a build of the controller against them."""

import numpy as np

from plant.backends.c_code import Real, literal
from tuner.exchange.c99.golden import Golden

HEADER = """\
/* golden.h: what {p}_controller.c takes, gives and then keeps, bit for bit, written by {tool}. Worked out by the
   simulator's own functions in {real}. Rows: members of the structures in their order, steps one after another.

   gains         {digest}
   airframe      {airframe}, laws {laws} */

#ifndef GOLDEN_H
#define GOLDEN_H

{defines}

{arrays}

#endif
"""
PROGRAM = """\
/* test_golden.c: compares {p}_controller.c with the golden vectors, bit for bit. Written by {tool} for the gains
   {digest}
   of {airframe} ({laws}). Prints and returns 1 at the first difference. */

#include "{p}_controller.h"

#include "golden.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* 1 where n numbers differ, after saying which. */
static int differs(const char *what, unsigned step, const void *got, const {p}_real *wanted, unsigned n)
{{
    unsigned i;
    for (i = 0; i < n; ++i) {{
        {p}_real value;
        memcpy(&value, (const char *)got + i * sizeof value, sizeof value);
        if (memcmp(&value, &wanted[i], sizeof value) != 0) {{
            printf("step %u, %s, number %u: %.{digits}g, but golden.h has %.{digits}g\\n", step, what, i, (double)value,
                (double)wanted[i]);
            return 1;
        }}
    }}
    return 0;
}}

static int cascade(void)
{{
    {p}_state state, before;
    {p}_measurement m;
    {p}_reference reference;
    {p}_command command, last;
    unsigned k;
    memset(&state, 0, sizeof state);
    memcpy(&m, golden_start, sizeof m);
    if ({p}_init(&state, &m) != {P}_OK)
        return printf("{p}_init refused\\n"), 1;
    if (differs("initial state", 0, &state, golden_initial, GOLDEN_INITIAL))
        return 1;
    for (k = 0; k < GOLDEN_STEPS; ++k) {{
        memcpy(&reference, golden_inputs[k], sizeof reference);
        memcpy(&m, golden_inputs[k] + sizeof reference / sizeof({p}_real), sizeof m);
        if ({p}_step(&state, &reference, &m, &command) != {P}_OK)
            return printf("step %u: {p}_step refused\\n", k), 1;
        if (differs("command", k, &command, golden_outputs[k], GOLDEN_OUTPUTS)
            || differs("state", k, &state, golden_states[k], GOLDEN_STATES))
            return 1;
    }}
    before = state;
    last = command;
    m.rate.y = NAN;
    if ({p}_step(&state, &reference, &m, &command) != {P}_REFUSED || memcmp(&state, &before, sizeof state) != 0
        || memcmp(&command, &last, sizeof last) != 0)
        return printf("{p}_step took a NaN\\n"), 1;
    return 0;
}}

static int attitude(void)
{{
    {p}_attitude_state state, before;
    {p}_attitude_setpoint setpoint;
    {p}_attitude_measurement m;
    {p}_attitude_applied applied;
    {p}_vec3 torque, last;
    unsigned k;
    memset(&state, 0, sizeof state);
    memcpy(&m, golden_attitude_start, sizeof m);
    if ({p}_attitude_init(&state, &m) != {P}_OK)
        return printf("{p}_attitude_init refused\\n"), 1;
    if (differs("initial attitude state", 0, &state, golden_attitude_initial, GOLDEN_ATTITUDE_INITIAL))
        return 1;
    for (k = 0; k < GOLDEN_ATTITUDE_STEPS; ++k) {{
        const {p}_real *in = golden_attitude_inputs[k];
        memcpy(&setpoint, in, sizeof setpoint);
        memcpy(&m, in + sizeof setpoint / sizeof({p}_real), sizeof m);
        memcpy(&applied, in + (sizeof setpoint + sizeof m) / sizeof({p}_real), sizeof applied);
        if ({p}_attitude_step(&state, &setpoint, &m, &applied, &torque) != {P}_OK)
            return printf("step %u: {p}_attitude_step refused\\n", k), 1;
        if (differs("torque", k, &torque, golden_attitude_outputs[k], GOLDEN_ATTITUDE_OUTPUTS)
            || differs("attitude state", k, &state, golden_attitude_states[k], GOLDEN_ATTITUDE_STATES))
            return 1;
    }}
    before = state;
    last = torque;
    m.angles.z = INFINITY;
    if ({p}_attitude_step(&state, &setpoint, &m, &applied, &torque) != {P}_REFUSED
        || memcmp(&state, &before, sizeof state) != 0 || memcmp(&torque, &last, sizeof last) != 0)
        return printf("{p}_attitude_step took an infinity\\n"), 1;
    return 0;
}}

static int measurements(void)
{{
    {p}_vec3 position, velocity, rate;
    {p}_quaternion q;
    {p}_measurement m;
    unsigned k;
    for (k = 0; k < GOLDEN_MEASUREMENTS; ++k) {{
        const {p}_real *in = golden_measure_inputs[k];
        memcpy(&position, in, sizeof position);
        memcpy(&velocity, in + 3, sizeof velocity);
        memcpy(&q, in + 6, sizeof q);
        memcpy(&rate, in + 10, sizeof rate);
        if ({p}_measure(&position, &velocity, &q, &rate, &m) != {P}_OK)
            return printf("attitude %u: {p}_measure refused\\n", k), 1;
        if (differs("measurement", k, &m, golden_measure_outputs[k], sizeof m / sizeof({p}_real)))
            return 1;
    }}
    q.w = q.x = q.y = q.z = 0;
    if ({p}_measure(&position, &velocity, &q, &rate, &m) != {P}_REFUSED)
        return printf("{p}_measure took a quaternion of length 0\\n"), 1;
    return 0;
}}

int main(void)
{{
    if (measurements() || cascade() || attitude())
        return 1;
    printf("the same bits: %u steps of the cascade, %u of the attitude loops\\n", (unsigned)GOLDEN_STEPS,
        (unsigned)GOLDEN_ATTITUDE_STEPS);
    return 0;
}}
"""


def golden_header(vectors: Golden, real: Real, words: dict[str, str]) -> str:
    """Write golden.h; words: p, P, digest, airframe, laws."""
    defines: list[str] = []
    arrays: list[str] = []
    for name, entry in (("", vectors.step), ("attitude_", vectors.attitude_step)):
        start, inputs = f"golden_{name}start", f"golden_{name}inputs"
        defines.append(f"#define GOLDEN_{name.upper()}STEPS {len(entry.inputs)}u")
        arrays.append(f"static const {words['p']}_real {start}[{len(entry.start)}] = {{{_row(entry.start, real)}}};")
        defines.append(f"#define GOLDEN_{name.upper()}INITIAL {len(entry.initial)}u")
        initial = f"golden_{name}initial[{len(entry.initial)}]"
        arrays.append(f"static const {words['p']}_real {initial} = {{{_row(entry.initial, real)}}};")
        arrays.append(_array(inputs, entry.inputs, real, words["p"]))
        for kind, table in (("outputs", entry.outputs), ("states", entry.states)):
            defines.append(f"#define GOLDEN_{name.upper()}{kind.upper()} {table.shape[1]}u")
            arrays.append(_array(f"golden_{name}{kind}", table, real, words["p"]))
    defines.append(f"#define GOLDEN_MEASUREMENTS {len(vectors.measure_inputs)}u")
    arrays.append(_array("golden_measure_inputs", vectors.measure_inputs, real, words["p"]))
    arrays.append(_array("golden_measure_outputs", vectors.measure_outputs, real, words["p"]))
    return HEADER.format(**words, real=real.name, defines="\n".join(defines), arrays="\n\n".join(arrays))


def golden_program(real: Real, words: dict[str, str]) -> str:
    """Write test_golden.c; words: as in `golden_header`."""
    return PROGRAM.format(**words, digits=17 if real.name == "double" else 9)


def _array(name: str, table: np.ndarray, real: Real, prefix: str) -> str:
    rows = ",\n".join(f"    {{{_row(row, real)}}}" for row in table)
    return f"static const {prefix}_real {name}[{len(table)}][{table.shape[1]}] = {{\n{rows}\n}};"


def _row(values: np.ndarray, real: Real) -> str:
    # Numbers as they are: what is too small to be normal stays so.
    return ", ".join(literal(float(value), real, raised=False).strip("()") for value in values)
