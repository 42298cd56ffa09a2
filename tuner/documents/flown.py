"""The Parquet files of a contest: scores, fans, flight 0 and its air. A file that is not there holds nothing."""

from pathlib import Path

import numpy as np

from tuner.documents.contest import Air, ContenderScores, Trace
from tuner.documents.files import groups
from tuner.documents.results import Fan
from tuner.store.document import refuse


def read_scores(file: Path) -> list[ContenderScores]:
    """Return the values of every contender in every quantity, over all scenarios that count for it."""
    found = []
    for (contender, quantity), values in groups(file, ["contender", "quantity"], ["value"]):
        if not np.isfinite(values).all():
            raise refuse(file, "the column 'value' holds something that is no finite number")
        found.append(ContenderScores(contender, quantity, np.sort(values[:, 0])))
    return found


def read_fans(file: Path) -> list[Fan]:
    """Return the fans of every contender, scenario and signal."""
    names, columns = ["point", "scenario", "signal", "unit"], ["time", "reference", "low", "median", "high"]
    return [
        Fan(point, scenario, signal, _shown(unit), *values.T)
        for (point, scenario, signal, unit), values in groups(file, names, columns)
    ]


def read_traces(file: Path) -> list[Trace]:
    """Return every signal of the single flights."""
    names, columns = ["contender", "scenario", "signal", "unit"], ["time", "value", "reference"]
    return [
        Trace(contender, scenario, signal, _shown(unit), *values.T)
        for (contender, scenario, signal, unit), values in groups(file, names, columns)
    ]


def read_air(file: Path) -> list[Air]:
    """Return the components of the air of the single flights."""
    return [
        Air(scenario, signal, _shown(unit), *values.T)
        for (scenario, signal, unit), values in groups(file, ["scenario", "signal", "unit"], ["time", "value"])
    ]


def _shown(unit: str) -> str:
    return "" if unit == "1" else unit
