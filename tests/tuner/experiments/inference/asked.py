"""A small inference as text: one pair of laws, two contenders, one axis, flights of 2 s."""

from pathlib import Path

import numpy as np

from objectives.metrics import parse
from objectives.problem import FlightBatch, Objective, Problem
from objectives.risk import Risk
from tuner.study.build import study_from_table

STUDY = """\
title = "Small inference"
seed = 7

[airframe]
name = "hummingbird"

[controller]
attitude = "hybrid"

[limits]
position = 50.0

[[contender]]
name = "soft"

[contender.gains]
"attitude.lambda" = 2.0
"attitude.k1" = 0.0
"attitude.k2" = 1.5

[[contender]]
name = "stiff v1.0"

[contender.gains]
"attitude.lambda" = 6.0
"attitude.k1" = 0.0
"attitude.k2" = 8.0

[[scenario]]
name = "level"
duration = 2.0

[scenario.reference]
kind = "level"

[scenario.air]
intensity = "none"
mean_wind = false
window = [0.0, 0.8]

[scenario.air.injection]
angular_sigma = [1.0, 0.0, 0.0]
angular_time = [0.1, 0.1, 0.1]

[scenario.sensors]
position = 0.0
velocity = 0.0
attitude = 0.0
rate = 0.0

[scenario.bands]
attitude = 0.012

[[objective]]
metric = "peak.roll"

[[unknown]]
name = "intensity"
unit = "rad/s2"
set = ["scenario.0.air.injection.angular_sigma.0"]
low = 0.2
high = 20.0
scale = "log"

[[unknown]]
name = "k2 of soft"
unit = "1/s"
set = ["contender.soft.gains.attitude.k2"]
low = 0.5
high = 20.0
scale = "log"

[search]
population = 12
generations = 6

[inference]
flights = 32
held_out = 96
"""
TRUTH = {"intensity": 3.0, "k2 of soft": 4.0}
"""What the synthetic paper flew; the study starts from 1.0 and 1.5."""
METRICS = ("peak.roll", "settling.roll")
CONTENDERS = ("soft", "stiff v1.0")
PUBLISHED_FLIGHTS = 256


def cell(contender, metric, value, scenario="level"):
    return (
        f'\n[[published]]\ncontender = "{contender}"\nmetric = "{metric}"\nscenario = "{scenario}"\nvalue = {value!r}\n'
    )


CELLS = "".join(cell(name, metric, 0.5) for metric in METRICS for name in CONTENDERS)


def changed(old, new, text=STUDY + CELLS):
    """Replace the one place where `old` stands."""
    assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times"
    return text.replace(old, new)


def write(folder: Path, text=STUDY + CELLS) -> Path:
    path = folder / "asked.toml"
    path.write_text(text, encoding="utf-8")
    return path


def flown_plainly(study_table, stream, count):
    """Scores (metrics, flights) of one contender's study content, flown as a tuning study flies its default."""
    study = study_from_table(Path("plain.toml"), study_table)
    objectives = tuple(Objective(parse(metric), Risk("mean"), "level") for metric in METRICS)
    problem = Problem(study.system, study.space, objectives, (), study.seed, 1)
    return problem.evaluate_gains(
        study.default_row[None], (FlightBatch(study.scenarios[0].spec, stream, count),)
    ).scores[0]


def plain_table(name, intensity, soft_k2):
    """The content of one contender's study with the unknowns put in by hand."""
    import tomllib

    table = tomllib.loads(STUDY)
    gains = next(entry["gains"] for entry in table["contender"] if entry["name"] == name)
    if name == "soft":
        gains["attitude.k2"] = soft_k2
    table["scenario"][0]["air"]["injection"]["angular_sigma"][0] = intensity
    for key in ("contender", "unknown", "inference"):
        del table[key]
    return {**table, "gains": gains}


def synthetic_paper(stream, count=PUBLISHED_FLIGHTS):
    """Scores (contender, metric) -> (flights,) of the truth, in the order of CELLS."""
    flown = {
        name: flown_plainly(plain_table(name, TRUTH["intensity"], TRUTH["k2 of soft"]), stream, count)
        for name in CONTENDERS
    }
    return {(name, metric): flown[name][i] for i, metric in enumerate(METRICS) for name in CONTENDERS}


def published_medians(scores, **changes):
    """The cells of a synthetic paper as text; changes: factors on cells by "contender metric"."""
    return "".join(
        cell(name, metric, float(np.median(row)) * changes.get(f"{name} {metric}", 1.0))
        for (name, metric), row in scores.items()
    )
