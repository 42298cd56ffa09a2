"""The [gains] table of a plant study, fixed and searched gains."""

from collections.abc import Mapping

from objectives.decisions import DecisionSpace, Variable
from objectives.plant_system import PlantSystem
from plant.errors import InputError, UnknownNameError
from plant.quadrotor.gains import GainAddress
from tuner.gains.ranges import check_value
from tuner.study.plant_schema import PlantGainTable

# Units of gains that have no sign whatever the plant's is: times, frequencies, ratios.
SIGNLESS = ("s", "Hz", "rad/s", "1")


def plant_space(table: Mapping[str, float | PlantGainTable], system: PlantSystem) -> DecisionSpace:
    """Return the decision space of a plant's [gains] table.

    The table names every gain that is not optional. Raises InputError with the key inside it.
    """
    every_gain = system.gains
    by_address = {gain.address: gain for gain in every_gain}
    for key in table:
        if key not in by_address:
            raise UnknownNameError("gain", key, by_address, key=key)
    base, variables, columns = [0.0] * len(every_gain), [], []
    for gain in every_gain:
        entry = table.get(gain.address, gain.default if gain.info.optional else None)
        if entry is None:
            raise InputError(
                f"is not given; write a number, or a range {{ low = ..., high = ... }} [{gain.unit}]: {gain.info.meaning}",
                key=gain.address,
            )
        if isinstance(entry, PlantGainTable):
            variable, base[gain.column] = _variable(entry, gain, system)
            variables.append(variable)
            columns.append((gain.column,))
        else:
            _check_sign(gain, entry, system)
            check_value(gain.address, gain, entry, system.timing.control_period)
            base[gain.column] = entry
    return DecisionSpace(tuple(variables), tuple(columns), tuple(base))


def _variable(entry: PlantGainTable, gain: GainAddress, system: PlantSystem) -> tuple[Variable, float]:
    if entry.tie is not None:
        raise InputError("gains of channels are not tied; give a range or a number", key=f"{gain.address}.tie")
    if entry.low is None or entry.high is None:
        raise InputError(
            f"needs low and high [{gain.unit}]; the usual ranges are those of quadrotors", key=gain.address
        )
    _check_sign(gain, entry.low, system)
    variable = Variable(gain.address, (gain.address,), entry.low, entry.high, entry.scale or gain.info.scale)
    default = variable.middle() if entry.default is None else entry.default
    for value in (entry.low, entry.high, default):
        check_value(gain.address, gain, value, system.timing.control_period)
    if not entry.low <= default <= entry.high:
        raise InputError(
            f"given {default:g}, outside its range of {entry.low:g} to {entry.high:g}", key=f"{gain.address}.default"
        )
    return variable, default


def _check_sign(gain: GainAddress, value: float, system: PlantSystem) -> None:
    """Raise InputError for a gain whose negative sign belongs to b0."""
    b0 = system.plan.channel(gain.axis).b0
    if value < 0.0 < b0 and (gain.info.integrals is not None or gain.unit not in SIGNLESS):
        raise InputError(
            f"given {value:g} {gain.unit}; gains are not negative: where more command lowers the output, write b0 = {-b0:g} for "
            f"channel '{gain.axis}' and the gain without its sign",
            key=gain.address,
        )
