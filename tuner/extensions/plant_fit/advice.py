"""What the data do not show, and the experiment that would."""

from collections.abc import Sequence

from tuner.extensions.plant_fit.intervals import FittedPlant, Number
from tuner.extensions.plant_fit.study_file import Signals


def notes_of(plant: FittedPlant, signals: Signals, i: int, numbers: Sequence[Number]) -> list[str]:
    """Return notes on numbers that are not identified."""
    unknown = sorted({number.name for number in numbers if not number.is_identified})
    return [f"not identified: {', '.join(unknown)}"] if unknown else []
