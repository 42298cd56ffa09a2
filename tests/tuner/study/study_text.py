"""A small good study as text, and how to change it."""

from pathlib import Path

STUDY = """\
title = "Test"
seed = 1

[airframe]
name = "hummingbird"

[controller]
attitude = "hybrid"

[gains]
"tilt.lambda" = { low = 1, high = 16 }
"roll.k1" = 20.0

[[scenario]]
name = "gusts"
duration = 2.0
search = 4
held_out = 8

[scenario.reference]
kind = "steps"
x = 1.0
time = 0.5

[scenario.air]
intensity = "light"

[scenario.spread]
mass = 0.1

[[objective]]
metric = "itae.position"
risk = "cvar"
level = 0.9

[[objective]]
metric = "travel"

[[constraint]]
metric = "failure"
max = 0.0

[search]
population = 8
generations = 2
starts = []

[pick]
rule = "knee"
"""


def changed(old: str, new: str, text: str = STUDY) -> str:
    """Replace the one place where `old` stands."""
    assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times"
    return text.replace(old, new)


def with_gains(lines: str) -> str:
    """Replace the whole [gains] table."""
    head, rest = STUDY.split("[gains]\n")
    return f"{head}[gains]\n{lines}\n\n[[scenario]]{rest.split('[[scenario]]', 1)[1]}"


def write(folder: Path, text: str) -> Path:
    """Write a study file into a folder."""
    path = folder / "asked.toml"
    path.write_text(text, encoding="utf-8")
    return path
