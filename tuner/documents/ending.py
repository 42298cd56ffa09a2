"""The end of a run, as its folder tells it: gains to recommend, or the nearest point to what was asked."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from plant.input_files import read_input_text

GAINS, INFEASIBLE = "gains.json", "infeasible.json"
"""Where a run leaves its recommended gains, and where those of the nearest point if nothing was feasible."""
NOTHING = "Nothing feasible"
"""What the first line begins with wherever a run that recommends nothing is told."""


def is_feasible(summary: Mapping[str, Any]) -> bool:
    """Return whether the summary of a run recommends anything; folders of earlier versions tell it by their conflict."""
    return bool(summary.get("feasible", summary.get("conflict") is None))


def shown_point(summary: Mapping[str, Any]) -> str:
    """Return the point that stands beside the default: the recommended one, else the nearest to feasible."""
    return str(summary["tuned"] if summary.get("tuned") is not None else summary["nearest"])


def shown_as(summary: Mapping[str, Any]) -> str:
    """Return what that point is called at the head of a column."""
    return "tuned" if is_feasible(summary) else "nearest"


def gains_name(feasible: bool) -> str:
    """Return the name of the file that a run leaves the gains of that point in."""
    return GAINS if feasible else INFEASIBLE


def gains_file(summary: Mapping[str, Any]) -> str:
    """Return the name of that file in a folder with this summary; those of earlier versions have but one."""
    return gains_name(summary.get("feasible", True))


def is_recommended(file: Path) -> bool:
    """Return whether a gains file that can be read says nothing against being flown."""
    return bool(json.loads(read_input_text(file)).get("study", {}).get("feasible", True))
