"""A small good contest as text, and how to change it."""

from pathlib import Path

CONTEST = """\
title = "Test"
seed = 3

[airframe]
name = "hummingbird"

[controller]
attitude = "hybrid"

[gains]
"attitude.lambda" = 7.0

[[scenario]]
name = "gusts"
duration = 1.0
search = 4
held_out = 8

[scenario.reference]
kind = "steps"
x = 1.0
time = 0.2

[scenario.air]
intensity = "light"

[scenario.spread]
mass = 0.1

[[scenario]]
name = "calm"
duration = 1.2
search = 2
held_out = 6

[[objective]]
metric = "itae.position"
risk = "cvar"
level = 0.5

[[objective]]
metric = "travel"

[[constraint]]
metric = "failure"
max = 0.0

# A second is too short to fly a metre: the mission is set aside.
[[constraint]]
metric = "rms.position"
risk = "quantile"
level = 0.5
scenario = "gusts"
max = 100.0

[search]
population = 8
generations = 3
starts = []

[[contender]]
name = "PID"
controller = { attitude = "pid", position = "pid" }

[contender.gains]
"attitude.kp" = { low = 20.0, high = 200.0 }
"attitude.kd" = 14.0

[[contender]]
name = "The hybrid, v1.0"

[[contender]]
name = "LADRC"
airframe = { name = "f450" }
controller = { attitude = "ladrc" }

[contender.gains]
"attitude.omega_c" = 0.3

[[published]]
contender = ["PID", "LADRC"]
metric = "peak.roll"
scenario = "gusts"
value = 0.2

[[published]]
contender = "PID"
metric = "peak.roll"
scenario = "gusts"
value = 0.1
fitted = true

[[claim]]
better = "LADRC"
than = "PID"
in = ["itae.position", "peak.roll", "rms.yaw"]
text = "LADRC is better"
"""

NAMES = ["PID", "The hybrid, v1.0", "LADRC"]


def changed(old: str, new: str, text: str = CONTEST) -> str:
    """Replace the one place where `old` stands."""
    assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times"
    return text.replace(old, new)


def write(folder: Path, text: str = CONTEST, name: str = "contest.toml") -> Path:
    """Write a file into a folder."""
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path
