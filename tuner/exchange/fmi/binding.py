"""binding.h: what ties the general FMI code to one controller, written as C."""

from collections.abc import Sequence

from tuner.exchange.fmi.variables import Variable

BINDING = """\
/* {heading} */

#ifndef BINDING_H
#define BINDING_H

#include "{header}"

#define MODEL_GUID "{guid}"
#define CONTROL_PERIOD {period!r}
#define PERIOD_TEXT "{period:.10g}"
#define INPUTS {inputs}u
#define OUTPUTS {outputs}u
#define CONSTANTS {constants}u

static const double start_inputs[INPUTS] = {{
{start_inputs}
}};

static const double start_outputs[OUTPUTS] = {{
{start_outputs}
}};

static const double constants[CONSTANTS] = {{
{constant_values}
}};

static void take_inputs(const double *in, {prefix}_reference *into_reference, {prefix}_measurement *into_measurement)
{{
    {prefix}_reference reference;
    {prefix}_measurement measurement;
{take}
    *into_reference = reference;
    *into_measurement = measurement;
}}

static int start_controller({prefix}_state *state, const double *in)
{{
    {prefix}_reference reference;
    {prefix}_measurement measurement;
    take_inputs(in, &reference, &measurement);
    return (int){prefix}_init(state, &measurement);
}}

/* {when} */
static int step_controller({prefix}_state *state, const double *in, double *out)
{{
    {prefix}_reference reference;
    {prefix}_measurement measurement;
    {prefix}_command command;
    int status;
    take_inputs(in, &reference, &measurement);
    status = (int){prefix}_step(state, &reference, &measurement, &command);
{ahead}    if (status != 0)
        return status;
{give}
    return 0;
}}

#endif
"""
AT_ONCE = "The outputs are the command that the controller puts in force."
AHEAD = (
    "The controller was tuned for a command that comes into force one period after its measurement. A co-simulation makes that "
    "period itself, so the outputs are the command that a further step would put in force."
)
FURTHER_STEP = """\
    if (status == 0) {{
        {prefix}_state ahead = *state;
        status = (int){prefix}_step(&ahead, &reference, &measurement, &command);
    }}
"""


def binding(
    found: Sequence[Variable], heading: Sequence[str], guid: str, period: float, delayed: bool, header: str, prefix: str
) -> str:
    """Return binding.h; delayed: whether the controller is tuned for one period of delay."""
    inputs, outputs, constants = ([entry for entry in found if entry.kind == kind] for kind in KINDS)
    return BINDING.format(
        heading="\n   ".join(heading),
        header=header,
        prefix=prefix,
        guid=guid,
        period=period,
        inputs=len(inputs),
        outputs=len(outputs),
        constants=len(constants),
        start_inputs=_values(inputs),
        start_outputs=_values(outputs),
        constant_values=_values(constants),
        take="\n".join(
            f"    {entry.member} = ({REAL.format(prefix=prefix)})in[{i}];" for i, entry in enumerate(inputs)
        ),
        give="\n".join(f"    out[{i}] = (double)command.{entry.member};" for i, entry in enumerate(outputs)),
        when=AHEAD if delayed else AT_ONCE,
        ahead=FURTHER_STEP.format(prefix=prefix) if delayed else "",
    )


KINDS = ("input", "output", "constant")
REAL = "{prefix}_real"


def _values(entries: Sequence[Variable]) -> str:
    return "\n".join(f"    {float(entry.start)!r}, /* {entry.name} [{entry.unit}] */" for entry in entries)
