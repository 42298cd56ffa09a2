"""Load a study that tunes one controller, for commands that take no contest and no inference."""

from pathlib import Path

from plant.errors import InputError
from tuner.study import load_study
from tuner.study.contest_reading import is_contest
from tuner.study.inference_reading import is_inference
from tuner.study.study import Study


def tuning_study(path: Path, command: str) -> Study:
    """Return the study of a file; InputError where it is a contest or an inference."""
    for asked, kind, table in ((is_inference, "an inference", "unknown"), (is_contest, "a contest", "contender")):
        if asked(path):
            raise InputError(f"this is {kind}; `{command}` takes a study of one controller", file=path, key=table)
    return load_study(path)
