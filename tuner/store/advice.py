"""Advice on a results folder that is unfinished or damaged: go on with it, or have it written again.

Told from its run.json alone, because the error may occur in any other work.
"""

import shlex
from pathlib import Path

from plant.errors import InputError
from plant.input_files import parse_json, read_input_text
from plant.texts import toml_table

RECORD = "run.json"
TUNING, CONTEST, JUDGEMENT = "tuning", "contest", "judgement"
PLANT, TRIALS = "plant", "trials"
FLOWN_AGAIN = (TUNING, PLANT)
"""Kinds of runs that `tuner verify` flies again."""
RESUMED = (TUNING, PLANT, CONTEST)
"""Kinds of run that `tuner resume` goes on with."""
STEPS = "stages.json"
"""File of a tail's or an autotune's folder: its steps with their inputs."""
CONTENDERS = "contenders"
"""Folder of a contest's folder in which its contenders' runs lie."""
POINTS = "points"
"""Folder of a results folder in which the gains of its named points lie."""


def kind_of(path: Path) -> str | None:
    """Return the kind of run that a folder is of; None where nothing tells."""
    try:
        kind = parse_json(read_input_text(path / RECORD))["kind"]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return kind if isinstance(kind, str) else None


def is_codeless(path: Path) -> bool:
    """Return True if no file holds the plant of a folder's run.

    Such is the plant of a notebook's cell.
    """
    inputs = list((path / "inputs").glob("*"))
    return (
        kind_of(path) == PLANT and all(file.suffix == ".toml" for file in inputs) and not any(map(_is_linear, inputs))
    )


def _is_linear(study: Path) -> bool:
    """True for a study that gives its plant by numbers."""
    try:
        plant = toml_table(read_input_text(study, "utf-8-sig"), study).get("plant", {})
    except (OSError, ValueError, InputError):
        return False
    return isinstance(plant, dict) and not {"transfer_function", "state_space"}.isdisjoint(plant)


def can_be_resumed(path: Path) -> bool:
    """Return True where `tuner resume` continues a folder."""
    return kind_of(path) in RESUMED and not is_codeless(path)


def run_root(path: Path) -> Path:
    """Return the folder that is gone on with: that of the contest for the run of a contender."""
    above = path.parent.parent
    return above if path.parent.name == CONTENDERS and kind_of(above) == CONTEST else path


def resume_hint(path: Path, made: bool = False) -> str:
    """Return the command that finishes a folder, as a sentence's end.

    made: whether the command that failed made the folder.
    """
    run = run_root(path)
    if can_be_resumed(run):
        return f"go on with `tuner resume {shlex.quote(str(run))}`"
    if kind_of(run) == TRIALS or (run / STEPS).exists():
        return "give the command again"
    return f"remove {run} and give the command again" if made else "give the command again"


def repair_hint(path: Path, name: str) -> str:
    """Return the command that repairs a file, as a sentence's end."""
    if name == RECORD or name.startswith("inputs/"):
        return restart_hint(path)
    run = run_root(path)
    if can_be_resumed(run):
        return f"`tuner resume {shlex.quote(str(run))}` writes it again"
    drawn = name == "report.html" or name.startswith("figures/")
    if drawn and ((path / "comparison.json").exists() or kind_of(path) == JUDGEMENT):
        return f"`tuner report {shlex.quote(str(path))}` writes it again"
    return "give the command again with another --out"


def restart_hint(path: Path) -> str:
    """Return the advice for a run that cannot be continued."""
    if kind_of(path) == CONTEST:
        return "run the study again into a new folder"
    return f"run the study again with `--reuse {shlex.quote(str(path))}`, which takes over the flights that are there"
