"""Advice on a results folder that is unfinished or damaged: go on with it, or have it written again.

Told from its run.json alone, for whoever reports the error may be at any other work.
"""

import shlex
from pathlib import Path

from plant.input_files import parse_json, read_input_text

RECORD = "run.json"
TUNING, CONTEST, INFERENCE, JUDGEMENT = "tuning", "contest", "inference", "judgement"
PLANT, TRIALS = "plant", "trials"
FLOWN_AGAIN = (TUNING, PLANT)
"""Kinds of runs that `tuner verify` flies again."""
RESUMED = (TUNING, PLANT, CONTEST, INFERENCE)
"""Kinds of run that `tuner resume` goes on with."""
CONTENDERS = "contenders"
"""Folder of a contest's folder in which its contenders' runs lie."""


def kind_of(path: Path) -> str | None:
    """Return the kind of run that a folder is of; None where nothing tells."""
    try:
        kind = parse_json(read_input_text(path / RECORD))["kind"]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return kind if isinstance(kind, str) else None


def is_codeless(path: Path) -> bool:
    """Return whether a folder is of the run of a plant that no file holds, such as that of a notebook's cell."""
    return kind_of(path) == PLANT and all(file.suffix == ".toml" for file in (path / "inputs").glob("*"))


def can_be_resumed(path: Path) -> bool:
    """Return whether `tuner resume` goes on with a folder."""
    return kind_of(path) in RESUMED and not is_codeless(path)


def whole(path: Path) -> Path:
    """Return the folder that is gone on with: that of the contest for the run of a contender."""
    above = path.parent.parent
    return above if path.parent.name == CONTENDERS and kind_of(above) == CONTEST else path


def go_on(path: Path, made: bool = False) -> str:
    """Return what brings an unfinished folder to its end, as the end of a sentence; made: by the command that failed."""
    asked = whole(path)
    if can_be_resumed(asked):
        return f"go on with `tuner resume {shlex.quote(str(asked))}`"
    if kind_of(asked) == TRIALS:
        return "give the command again"
    return f"remove {asked} and give the command again" if made else "give the command again"


def mend(path: Path, name: str) -> str:
    """Return what writes a missing or damaged file of a folder again, as the end of a sentence."""
    if name == RECORD or name.startswith("inputs/"):
        return again(path)
    asked = whole(path)
    if can_be_resumed(asked):
        return f"`tuner resume {shlex.quote(str(asked))}` writes it again"
    drawn = name == "report.html" or name.startswith("figures/")
    if drawn and ((path / "comparison.json").exists() or kind_of(path) == JUDGEMENT):
        return f"`tuner report {shlex.quote(str(path))}` writes it again"
    return "give the command again with another --out"


def again(path: Path) -> str:
    """Return what to do where a run cannot be continued."""
    if kind_of(path) in (CONTEST, INFERENCE):
        return "run the study again into a new folder"
    return f"run the study again with `--reuse {shlex.quote(str(path))}`, which takes over the flights that are there"
