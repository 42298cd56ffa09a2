"""The measuring program: the controller's C code driven by recorded inputs, counting the instructions of every step."""

from collections.abc import Iterable, Sequence

from plant.records import paths
from plant.references.track import Reference
from plant.sensors import Measurement
from tuner.exchange.processor_cost.inputs import Instant, attitude_row, step_row
from tuner.exchange.texts import filled

ATTITUDE_MEMBERS = (
    *[f"setpoint.{name}" for name in ("roll", "pitch", "yaw", "yaw_rate")],
    *[f"seen.{name}.{axis}" for name in ("angles", "rate") for axis in "xyz"],
    *[f"applied.{name}.{axis}" for name in ("effect", "excess") for axis in "xyz"],
)
STEP_MEMBERS = (
    *[f"reference.{path}" for path in paths(Reference)],
    *[f"measurement.{path}" for path in paths(Measurement)],
)


def measuring_program(instants: Sequence[Instant], header: str, prefix: str, real: str) -> str:
    """Return the C source of the program.

    It prints the sizes of the state of the cascade and of the attitude loops [bytes]; for every instant the instructions of the
    attitude step and of the step of the cascade, each from before its call to after its return; last, thrust of the cascade [N]
    and torque of the attitude loops [N m], which tell that both were given what was recorded.
    """
    return filled(
        "processor_cost",
        "main.c",
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
