"""Studies that name their target: its laws, rates, ranges and steps; what it cannot hold is refused when the study is read."""

import re
from pathlib import Path

import numpy as np
import pytest

from plant.errors import InputError
from tuner.study.build import load_study
from tuner.study.study import Study
from tuner.study.targets import TARGETS

TEXT = """
title = "target"
seed = 1
target = "{target}"

[airframe]
name = "f450"

[gains]
{gains}

[[scenario]]
name = "calm"
duration = 1.0

[[objective]]
metric = "rms.position"
"""


def study_of(folder: Path, target: str, gains: str = '"tilt.p" = {}', more: str = "") -> Study:
    file = folder / "study.toml"
    file.write_text(TEXT.format(target=target, gains=gains) + more)
    return load_study(file)


@pytest.mark.parametrize("name", TARGETS)
def test_a_target_gives_laws_rates_and_defaults(name: str, tmp_path: Path) -> None:
    gains = '"tilt.wc" = {}' if name == "betaflight_adrc" else '"tilt.p" = {}'
    study, target = study_of(tmp_path, name, gains), TARGETS[name]
    cascade = study.system.cascade
    assert (cascade.attitude.name, cascade.position.name) == (target.attitude, target.position)
    assert (study.system.timing.control_period, cascade.position_every) == (
        target.control_period,
        target.position_every,
    )
    held = {gain.address: float(study.default_row[gain.column]) for gain in study.system.gains}
    facts = cascade.attitude.on_airframe
    assert facts is not None
    for fact, values in facts(study.airframe.vehicle).items():
        assert {axis: held[f"{axis}.{fact}"] for axis in values} == values
    assert study.resolved()["target"] == name


def test_a_period_of_its_own_stays(tmp_path: Path) -> None:
    study = study_of(tmp_path, "px4", more="[controller]\ncontrol_period = 0.001\n")
    assert study.system.timing.control_period == 0.001 and study.system.cascade.position_every == 8


def test_betaflights_gains_are_whole_numbers_all_over_their_range(tmp_path: Path) -> None:
    study = study_of(tmp_path, "betaflight", '"tilt.p" = { low = 20.4, high = 60.7 }\n"attitude.d_lpf1" = {}')
    points = np.random.default_rng(1).uniform(size=(200, 2))
    points[:2] = [[0.0, 0.0], [1.0, 1.0]]
    values = study.space.values(points)
    assert np.array_equal(values, np.rint(values))
    assert values[:, 0].min(axis=0) == 21.0 and values[:, 0].max(axis=0) == 60.0


REFUSED = [
    ("px5", '"tilt.p" = {}', "", "target: unknown target 'px5'; did you mean 'px4'"),
    ("px4", '"tilt.p" = { high = 0.9 }', "", r"gains.tilt.p: given 0.01 to 0.9 s/rad for roll.p (MC_*RATE_P); allowed with this target"),
    ("px4", '"yaw.p" = 0.9', "", "gains.yaw.p: given 0.9 s/rad for yaw.p"),
    ("px4", '"tilt.d_cutoff" = {}', "", 'has one d_cutoff for roll, pitch, yaw; search or fix it for all of them: "attitude.d_cutoff"'),
    ("px4", '"tilt.authority" = {}', "", "'roll.authority' is a fact of the airframe"),
    ("crazyflie", '"tilt.i_limit" = {}', "", "'roll.i_limit' is a fact of the firmware"),
    ("px4", '"attitude.notch" = {}', "[controller]\ncontrol_period = 0.005\n", "attitude.notch: the usual range ends at 120 Hz"),
    ("px4", '"tilt.p" = {}', '[controller]\nattitude = "pid"\n', "controller.attitude: given 'pid'; the attitude loops of 'px4' are 'px4'"),
    ("px4", '"tilt.p" = {}', "[controller]\nposition_every = 65\n", "controller.position_every"),
    ("betaflight", '"tilt.p" = { low = 20.2, high = 20.8 }', "", "no multiple of 1 lies between"),
]  # fmt: skip


@pytest.mark.parametrize(("target", "gains", "more", "words"), REFUSED)
def test_what_a_target_cannot_hold_is_refused_in_one_line(
    target: str, gains: str, more: str, words: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=re.escape(words)) as refused:
        study_of(tmp_path, target, gains, more)
    assert "\n" not in str(refused.value)
