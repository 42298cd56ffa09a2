"""The measuring program: the controller's C code driven by recorded inputs, counting the instructions of every step."""

from collections.abc import Iterable, Sequence

from plant.records import paths
from plant.references.track import Reference
from plant.sensors import Measurement
from tuner.exchange.processor_cost.inputs import Instant, attitude_row, step_row

ATTITUDE_MEMBERS = (
    *[f"setpoint.{name}" for name in ("roll", "pitch", "yaw", "yaw_rate")],
    *[f"seen.{name}.{axis}" for name in ("angles", "rate") for axis in "xyz"],
    *[f"applied.{name}.{axis}" for name in ("effect", "excess") for axis in "xyz"],
)
STEP_MEMBERS = (
    *[f"reference.{path}" for path in paths(Reference)],
    *[f"measurement.{path}" for path in paths(Measurement)],
)

MAIN = """\
#include <stdio.h>
#include "{header}"
#include "ticks.h"

#define INSTANTS {count}
static const {real} step_inputs[INSTANTS][{step_width}] = {{
{step_rows}
}};
static const {real} attitude_inputs[INSTANTS][{attitude_width}] = {{
{attitude_rows}
}};
static {prefix}_state state;
static {prefix}_reference reference;
static {prefix}_measurement measurement;
static {prefix}_command command;
static {prefix}_attitude_state attitude;
static {prefix}_attitude_setpoint setpoint;
static {prefix}_attitude_measurement seen;
static {prefix}_attitude_applied applied;
static {prefix}_vec3 torque;
static unsigned empty;

static void take_step_inputs(int k)
{{
    const {real} *const in = step_inputs[k];
{take_step}
}}

static void take_attitude_inputs(int k)
{{
    const {real} *const in = attitude_inputs[k];
{take_attitude}
}}

static unsigned counted_step(void)
{{
    const unsigned before = ticks_now();
    (void){prefix}_step(&state, &reference, &measurement, &command);
    return instructions(ticks_between(before, ticks_now()), empty);
}}

static unsigned counted_attitude_step(void)
{{
    const unsigned before = ticks_now();
    (void){prefix}_attitude_step(&attitude, &setpoint, &seen, &applied, &torque);
    return instructions(ticks_between(before, ticks_now()), empty);
}}

int main(void)
{{
    unsigned before;
    ticks_start();
    before = ticks_now();
    empty = ticks_between(before, ticks_now());
    take_step_inputs(0);
    take_attitude_inputs(0);
    if ({prefix}_init(&state, &measurement) != 0 || {prefix}_attitude_init(&attitude, &seen) != 0)
        return 1;
    printf("%u %u\\n", (unsigned)sizeof state, (unsigned)sizeof attitude);
    for (int k = 0; k < INSTANTS; ++k) {{
        unsigned whole;
        take_step_inputs(k);
        take_attitude_inputs(k);
        whole = counted_step();
        printf("%u %u\\n", counted_attitude_step(), whole);
    }}
    printf("%.9g %.9g %.9g %.9g\\n", (double)command.thrust, (double)torque.x, (double)torque.y, (double)torque.z);
    return 0;
}}
"""


def measuring_program(instants: Sequence[Instant], header: str, prefix: str, real: str) -> str:
    """Return the C source of the program.

    It prints the sizes of the state of the cascade and of the attitude loops [bytes]; for every instant the instructions of the
    attitude step and of the step of the cascade, each from before its call to after its return; last, thrust of the cascade [N]
    and torque of the attitude loops [N m], which tell that both were given what was recorded.
    """
    return MAIN.format(
        header=header,
        prefix=prefix,
        real=real,
        count=len(instants),
        step_width=len(STEP_MEMBERS),
        attitude_width=len(ATTITUDE_MEMBERS),
        step_rows=_rows(map(step_row, instants)),
        attitude_rows=_rows(map(attitude_row, instants)),
        take_step=_assignments(STEP_MEMBERS),
        take_attitude=_assignments(ATTITUDE_MEMBERS),
    )


def _rows(rows: Iterable[Sequence[float]]) -> str:
    """Return numbers in hexadecimal, so that none is rounded twice."""
    return ",\n".join("    {" + ", ".join(float(value).hex() for value in row) + "}" for row in rows)


def _assignments(members: Sequence[str]) -> str:
    return "\n".join(f"    {member} = in[{i}];" for i, member in enumerate(members))
