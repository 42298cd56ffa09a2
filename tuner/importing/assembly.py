"""From gains by axis to a controller: what every importer does once it has them."""

from collections.abc import Mapping
from math import ceil, degrees
from pathlib import Path

from plant.airframes import Airframe
from plant.cascade import ATTITUDE_AXES, AXES, close_cascade
from plant.errors import InputError
from plant.gains import default_row, gain_addresses
from plant.laws import law
from plant.laws.pid import Gains
from plant.nominal import ControlOptions
from tuner.export.autopilot_pid import with_gains
from tuner.export.exporter import Option
from tuner.export.settings import number
from tuner.gains_file import Controller
from tuner.study.gains import check_value
from tuner.study.timing import LONGEST, SHORTEST, check_plant_step, timing_of

# Our tilt limit, where the file's lies outside [rad].
LEAST_TILT, MOST_TILT = 0.05, 1.05
# Longest plant step [s], and its largest share of the rotors' lag.
STEP, SHARE = 0.001, 0.5

CURVE = Option(
    "thrust_curve", "factor f of the rotors' thrust T = T_max (f u^2 + (1 - f) u) of the command u, 0 to 1", default="1"
)
ATTITUDE_FILTER = Option(
    "attitude_filter", "time constant t_f of our derivative filter in the attitude loops, s", default="0.005"
)
POSITION_FILTER = Option(
    "position_filter", "time constant t_f of our derivative filter in the position loops, s", default="0.01"
)
DERIVATIVE = Option(
    "rate_derivative",
    "gains on measured acceleration, which our law has not: drop leaves them out, inertia counts them as added inertia",
    ("drop", "inertia"),
    "drop",
)


def control_period(default: str) -> Option:
    """Return the option of the control period with the target's usual one [s]."""
    return Option("control_period", "period of our controller, s", default=default)


def curve(settings: Mapping[str, str]) -> float:
    """Return the factor of the thrust curve [1]."""
    return number(settings, CURVE.name, 0.0, 1.0, "1")


def filters(settings: Mapping[str, str]) -> dict[str, float]:
    """Return the time constant of the derivative filter by axis [s]."""
    attitude = number(settings, ATTITUDE_FILTER.name, 0.0, 1.0, "s")
    position = number(settings, POSITION_FILTER.name, 0.0, 1.0, "s")
    return {axis: attitude if axis in ATTITUDE_AXES else position for axis in AXES}


def assumed_note(settings: Mapping[str, str]) -> str:
    """Return the sentence about what no parameter file tells."""
    return (
        f"The file does not tell our control period (taken as {settings['control_period']} s) and our derivative filters "
        f"({settings[ATTITUDE_FILTER.name]} s in the attitude, {settings[POSITION_FILTER.name]} s in the position loops): "
        "give --set control_period, attitude_filter, position_filter."
    )


def lightened(gains: Gains, share: float) -> Gains:
    """Return the gains of a loop whose derivative on the acceleration adds a share of the inertia."""
    return Gains(gains.kp / (1.0 + share), gains.ki / (1.0 + share), gains.kd / (1.0 + share), gains.t_f)


def controller(
    file: Path, airframe: Airframe, gains: Mapping[str, Gains], tilt: float, settings: Mapping[str, str]
) -> Controller:
    """Return a PID controller; axes without gains stand at the law's defaults. tilt: largest [rad], cut to what we know.

    Raises InputError naming file and gain where one is outside of what our law takes.
    """
    cascade = close_cascade(law("pid"), law("pid"))
    period = number(settings, "control_period", SHORTEST, LONGEST, "s")
    vehicle = airframe.vehicle
    count = ceil(period / min(STEP, SHARE * vehicle.lag_up, SHARE * vehicle.lag_down) - 1e-9)
    timing = timing_of(period, period / count)
    check_plant_step(timing, airframe)
    options = ControlOptions(tilt_limit=min(max(tilt, LEAST_TILT), MOST_TILT))
    found = Controller(airframe, cascade, options, period, timing.plant_step, tuple(default_row(cascade)))
    found = with_gains(found, gains)
    for gain in gain_addresses(cascade):
        try:
            check_value(gain.address, gain, found.gains[gain.column], period)
        except InputError as error:
            raise error.located(file=file) from None
    return found


def tilt_note(tilt: float, name: str) -> tuple[str, ...]:
    """Return a sentence where a tilt [rad] is cut."""
    if LEAST_TILT <= tilt <= MOST_TILT:
        return ()
    limit = min(max(tilt, LEAST_TILT), MOST_TILT)
    return (f"{name} = {degrees(tilt):.3g} deg is cut to {degrees(limit):.3g} deg, the limit of ours.",)


def absent_note(values: Mapping[str, float | str], wanted: Mapping[str, float | str], target: str) -> tuple[str, ...]:
    """Return a sentence that names what the file lacks and the defaults that stand in its place."""
    missing = [f"{name} = {_text(value)}" for name, value in wanted.items() if name not in values]
    return (f"Not in the file, so at the default of {target}: {', '.join(missing)}.",) if missing else ()


def _text(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:g}"


def inertia_note(shares: Mapping[str, float], counted: bool) -> tuple[str, ...]:
    """Return a sentence on derivative gains; shares: parameter -> share of the inertia that its gain adds [1]."""
    there = [f"{name} ({100.0 * share:.3g} %)" for name, share in shares.items() if share != 0.0]
    if not there:
        return ()
    what = "count as added inertia or mass" if counted else "are left out"
    return (
        f"Our law has no derivative on the acceleration: {what}, with the inertia or mass that they add: {', '.join(there)}.",
    )


def unused_note(values: Mapping[str, float], names: tuple[str, ...], what: str) -> tuple[str, ...]:
    """Return a sentence that names the parameters among some that are not 0."""
    there = [f"{name} = {values[name]:g}" for name in names if values.get(name, 0.0) != 0.0]
    return (f"{what}: {', '.join(there)}.",) if there else ()
