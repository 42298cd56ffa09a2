"""An experiment as a table of set points (CSV): for a Crazyflie, PX4 in offboard mode, and all that takes angles and height."""

from collections.abc import Mapping, Sequence

import numpy as np

from plant.references.spec import PITCH, ROLL, YAW, YAW_RATE
from tuner.extensions.flight_plans.choosing import TargetCapabilities
from tuner.extensions.flight_plans.excitation import LAG_CORNER, LEAD_CORNER, WAVES, Excitation, Shape, references
from tuner.extensions.flight_plans.excitation_target import ExcitationTarget
from tuner.extensions.flight_plans.flying import SimulatedVehicle

DEGREES = 180.0 / np.pi
COLUMNS = {
    "roll_deg": (ROLL, DEGREES),
    "pitch_deg": (PITCH, DEGREES),
    "yaw_deg": (YAW, DEGREES),
    "yaw_rate_deg_s": (YAW_RATE, DEGREES),
    "height_m": (2, 1.0),
    "climb_m_s": (5, 1.0),
    "climb_m_s2": (8, 1.0),
}
"""Column -> its place in a reference, and its unit over that of SI."""


def files(excitations: Sequence[Excitation], simulated: SimulatedVehicle) -> Mapping[str, bytes]:
    """Return the table, a row for each control period."""
    period = simulated.system.timing.control_period
    samples = references(excitations, period)
    table = np.column_stack(
        [period * np.arange(len(samples)), *[scale * samples[:, k] for k, scale in COLUMNS.values()]]
    )
    rows = [",".join(("time_s", *COLUMNS)), *[",".join(f"{value:.5g}" for value in row) for row in table.tolist()]]
    return {"excitation.csv": ("\n".join(rows) + "\n").encode()}


EXCITATIONS = ExcitationTarget(
    "csv",
    TargetCapabilities(
        {"roll": "angle", "pitch": "angle", "yaw": "rate", "lift": "acceleration"},
        waves=("chirp", "doublets"),
        lift_waves=WAVES,
        shape=Shape(lag=LAG_CORNER, lead=LEAD_CORNER),
    ),
    files,
    (
        "excitation.csv holds set points in FLU: roll right, pitch down and yaw left are positive; height counts from hover.",
        f"Amplitudes fall above {LAG_CORNER:g} Hz, to 0.18 at 20 Hz: of a level chirp, commands would grow with the frequency.",
        "Send either yaw or its rate, and of height, climb and its acceleration what your vehicle takes.",
    ),
)
