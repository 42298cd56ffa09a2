"""Studies whose trials a function of the tests makes, and the function."""

import json
from pathlib import Path

from tuner.extensions.trials.asking import ask, tell
from tuner.extensions.trials.study import TrialStudy
from tuner.study.kinds import load_any

TITLE = 'title = "Two bowls"\nseed = 7\n'
BOWLS = """
[trials]
search = 2
held_out = 3

[[variable]]
name = "x"
low = -1.0
high = 2.0
default = 1.5
unit = "m"
meaning = "place"

[[variable]]
name = "y"
low = -1.0
high = 1.0
default = 0.5

[[metric]]
name = "left"
unit = "m^2"
worst = 20.0

[[metric]]
name = "right"
worst = 20.0

[[objective]]
metric = "left"

[[objective]]
metric = "right"

[search]
algorithm = "random"
population = 8
generations = 2
"""


def bowls(folder: Path, changes=None, text=TITLE + BOWLS):
    """Return the study, written into a folder as bowls.toml."""
    file = folder / "bowls.toml"
    file.write_text(text)
    study = load_any(file, changes or {})
    assert isinstance(study, TrialStudy)
    return study


def made(trial):
    """Return the metrics of a trial, given as a dictionary: the squared distances to two points, the same in every scenario."""
    x, y = trial["variables"]["x"], trial["variables"]["y"]
    return {"left": x**2 + y**2, "right": (x - 1.0) ** 2 + y**2}


def noisy(trial):
    """Return the metrics of a trial with something of its own in every scenario."""
    return {name: value * (1.0 + (trial["seed"] % 97) / 970.0) for name, value in made(trial).items()}


def line(trial, metrics):
    """Return the line that tells a trial."""
    return json.dumps({"id": trial["id"], "metrics": metrics(trial)})


def concluded(study, out, metrics=made, answered=lambda lines: lines):
    """Ask and tell until the run is concluded; answered: what becomes of the lines of a round, such as another order."""
    while True:
        asked = ask(study, out)
        if asked.is_concluded:
            return out
        tell(out, answered([line(trial.content(), metrics) for trial in asked.trials]), "lines")


SAME = (
    "summary.json",
    "front.csv",
    "history.csv",
    "gains.json",
    "start.json",
    "asked.jsonl",
    "generations/0001.npz",
)
"""Files that are the same bytes however often a run was interrupted and in whatever order its trials were told."""


def content(out: Path):
    """Return these files of a folder."""
    return {name: (out / name).read_bytes() for name in SAME if (out / name).exists()}
