"""Fields of a plant may have any name of Python: what the generated code or its backends call something else changes no number."""

import re

import numpy as np
import pytest

from plant.errors import InputError
from plant.records import flatten
from tests.plant.model.plants import stepped
from tests.tuner.in_process import tuner
from tuner.study.kinds import load_any
from tuner.study.plant_study import PlantStudy

PLANT = '''"""A drive with two inputs."""

from typing import Annotated, NamedTuple


class State(NamedTuple):
    angle: Annotated[float, "rad"]
    speed: Annotated[float, "rad/s"]
    heat: Annotated[float, "K"]


class Input(NamedTuple):
    volt: Annotated[float, "V"]
    fan: Annotated[float, "1"]


class Disturbance(NamedTuple):
    torque: Annotated[float, "N m"]


class Parameters(NamedTuple):
    strength: Annotated[float, "1"] = 3.0
    friction: Annotated[float, "1"] = 2.0
    loss: Annotated[float, "1"] = 1.0


class Output(NamedTuple):
    turned: Annotated[float, "rad"]
    turning: Annotated[float, "rad/s"]


def derivative(x, u, d, p):
    return State(x.speed, p.strength * u.volt + d.torque - p.friction * x.speed, u.fan - p.loss * x.heat)


def output(x, u, d, p):
    return Output(x.angle, x.speed)
'''
STUDY = """
title = "Drive"
seed = 1

[plant]
file = "drive.py"
control_period = 0.01

[[actuator]]
name = "volt"
low = -12.0
high = 12.0
delay = 0.01
lag = 0.02

[[actuator]]
name = "fan"
low = -1.0
high = 1.0

[[channel]]
name = "wheel"
law = "pid"
output = "turned"
rate_output = "turning"
to = "volt"
lost_beyond = 10.0

[gains]
"wheel.kp" = { low = 1.0, high = 60.0, default = 10.0 }
"wheel.ki" = 0.1
"wheel.kd" = 1.0
"wheel.t_f" = 0.01

[[scenario]]
name = "turn"
duration = 1.0
reference.wheel = { kind = "step", size = 1.0 }
disturbance.torque = { kind = "step", size = 0.1 }
sensors.turned = { rms = 1e-4 }
spread = { strength = 0.2 }

[[objective]]
metric = "itae.wheel"

[[margin]]
quantity = "ms"
max = 3.0
"""
# Builtins, methods of tuples, what the written functions call their parts (one name inside another, too), words of C.
ODD = {
    "angle": "sum", "speed": "count", "heat": "range", "volt": "lags", "fan": "flags", "torque": "abs", "strength": "min",
    "friction": "select", "loss": "index", "turned": "max", "turning": "len", "wheel": "round",
}  # fmt: skip


def written(folder, names):
    folder.mkdir()

    def renamed(text):
        return re.sub(
            r"\b(" + "|".join(names or ["nothing"]) + r")\b", lambda found: names.get(found.group(), ""), text
        )

    (folder / "drive.py").write_text(renamed(PLANT), encoding="utf-8")
    (folder / "drive.toml").write_text(renamed(STUDY), encoding="utf-8")
    study = load_any(folder / "drive.toml")
    assert isinstance(study, PlantStudy)
    return study


def margin_of(study):
    (screen,) = study.screens
    return screen.analyse(study.default_row[None])[0, 0]


@pytest.mark.slow
def test_names_that_shadow_change_no_number(tmp_path, monkeypatch, capsys):
    plain, odd = written(tmp_path / "plain", {}), written(tmp_path / "odd", ODD)
    code, out, err = tuner(monkeypatch, capsys, "check", tmp_path / "odd" / "drive.toml")
    assert (code, err) == (0, "") and "round pid" in out
    assert margin_of(odd) == pytest.approx(margin_of(plain), rel=1e-12)
    # What is compiled flies what plain Python steps through.
    system, row = odd.system, odd.default_row
    drawn = system.sample(odd.scenarios[0].spec, odd.seed, "search", range(2))
    found = system.flyer(1).fly(row[None], system.nominal, drawn)[0]
    stepwise = np.array([flatten(stepped(system, row, drawn, lane)[1].meters) for lane in range(2)])
    assert np.isfinite(stepwise).all() and stepwise.any(axis=0).sum() > 5
    np.testing.assert_allclose(found[:, : stepwise.shape[1]], stepwise, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("name", ["lambda", "None", "_hidden"])
def test_what_python_takes_for_no_field_is_one_line(tmp_path, monkeypatch, capsys, name):
    (tmp_path / "drive.py").write_text(PLANT.replace("heat", name), encoding="utf-8")
    code, _, err = tuner(monkeypatch, capsys, "check", tmp_path / "drive.py")
    assert code == 2 and err.count("\n") == 1 and "drive.py" in err


def test_a_name_that_stands_for_a_part_of_the_loop_is_refused(tmp_path):
    with pytest.raises(InputError, match="the loop calls something else so: take another name"):
        written(tmp_path / "taken", {"wheel": "command"})
