"""[mission]: the limits that no study writes are moved, switched off and marked."""

import json

import numpy as np
import pytest

from objectives.mission import FOLLOWED, HELD
from plant.errors import InputError, UnknownNameError
from tests.tuner.in_process import tuner
from tests.tuner.study.study_text import STUDY, changed, write
from tuner.cli.app import parse_changes as overrides
from tuner.experiments.tuning.conflicts import automatic_limit_texts, conflict_of, conflict_texts, limits_of
from tuner.experiments.tuning.diagnosis import flown_obstacle, obstacle_texts
from tuner.search.loop import Archive
from tuner.study.build import load_study
from tuner.study.template import TEMPLATE

LABEL = "quantile50(rms.position)@gusts"
REST = changed('kind = "steps"\nx = 1.0\ntime = 0.5', 'kind = "hover"')


def with_mission(lines, text=STUDY):
    return f"{text}\n[mission]\n{lines}\n"


def automatic(folder, text):
    study = load_study(write(folder, text))
    return {entry.objective.label: (entry.most, entry.floor) for entry in study.automatic_limits}


def test_the_factor_of_a_moving_scenario_scales_its_limit(tmp_path):
    usual, key = automatic(tmp_path, STUDY)[LABEL]
    assert key == "mission.followed"
    half = automatic(tmp_path, with_mission(f"followed = {FOLLOWED / 2}"))[LABEL]
    assert half == (pytest.approx(usual / 2), key)
    # The other factor is of scenarios that rest.
    assert automatic(tmp_path, with_mission("held = 0.1"))[LABEL][0] == usual


def test_the_factor_of_a_resting_scenario_scales_its_limit(tmp_path):
    assert automatic(tmp_path, REST)[LABEL] == (HELD * 5.0, "mission.held")
    assert automatic(tmp_path, with_mission("held = 0.2", REST))[LABEL] == (pytest.approx(1.0), "mission.held")


@pytest.mark.parametrize("off", ["rms.position", "rms.position@gusts"])
def test_a_quantity_is_switched_off(tmp_path, off):
    assert automatic(tmp_path, with_mission(f'off = ["{off}"]')) == {}


def test_only_what_is_named_is_switched_off(tmp_path):
    text = STUDY.replace("x = 1.0\n", "x = 1.0\nyaw_deg = 30.0\n")
    both = automatic(tmp_path, text)
    left = automatic(tmp_path, with_mission('off = ["rms.position"]', text))
    assert set(both) == {LABEL, "quantile50(rms.yaw)@gusts"} and left == {
        "quantile50(rms.yaw)@gusts": both["quantile50(rms.yaw)@gusts"]
    }


@pytest.mark.parametrize(
    ("lines", "kind", "words"),
    [
        ("followed = 0.0", InputError, "mission.followed: given 0; allowed: above 0 up to 1"),
        ("held = 1.5", InputError, "mission.held: given 1.5"),
        ('off = ["rms.postion"]', UnknownNameError, "did you mean 'rms.position'"),
        ('off = ["rms.position@calm"]', UnknownNameError, "rms.position@gusts"),
        ("folowed = 0.5", UnknownNameError, "did you mean 'followed'"),
    ],
)
def test_nonsense_is_refused_with_its_key(tmp_path, lines, kind, words):
    with pytest.raises(kind) as refused:
        load_study(write(tmp_path, with_mission(lines)))
    assert "asked.toml" in str(refused.value) and words in str(refused.value)


def test_the_digest_sees_another_mission_and_no_usual_one(tmp_path):
    def digest(text):
        return load_study(write(tmp_path, text)).digest()

    assert digest(STUDY) == digest(with_mission(f"followed = {FOLLOWED}\nheld = {HELD}\noff = []"))
    assert digest(STUDY) != digest(with_mission("followed = 0.5"))


def test_the_template_shows_every_key_and_they_read_as_they_stand(tmp_path):
    shown = [
        line for line in TEMPLATE.splitlines() if line.startswith(("# [mission]", "# followed", "# held =", "# off"))
    ]
    assert len(shown) == 4
    text = TEMPLATE.replace("@TITLE@", "t")
    for line in shown:
        text = text.replace(line, line[2:])
    assert "rms.position" in load_study(write(tmp_path, text)).mission.off


def test_it_can_be_set_from_the_command_line(tmp_path):
    path = write(tmp_path, STUDY)
    changes = overrides(['mission.off=["rms.position"]'])
    assert load_study(path, changes).automatic_limits == ()


def test_a_conflict_with_one_says_so_and_names_the_key(tmp_path):
    study = load_study(write(tmp_path, STUDY))
    limits = limits_of(study.constraints, ())
    # Two candidates, each of which breaks one of: failure, the automatic limit.
    none = np.zeros((2, 0))
    found = Archive(
        np.zeros((2, 1)), np.zeros((2, 2)), np.array([[0.1, 0.0], [0.0, 0.2]]), none, np.ones(2, dtype=bool)
    )
    conflict = conflict_of(found, limits)
    assert conflict is not None
    (sentence, *_) = conflict_texts(conflict, limits)
    assert f"{LABEL} at most 0.6062 m (automatic: mission.followed)" in sentence
    assert "mean(failure) at most 0 " in sentence and sentence.count("automatic") == 1
    assert automatic_limit_texts(study.automatic_limits) == [
        f"Automatic limit: {LABEL} at most 0.6062 m (automatic: mission.followed)."
    ]


def test_an_obstacle_that_is_one_names_the_key_and_what_moves_it(tmp_path):
    study = load_study(write(tmp_path, STUDY))
    (limit,) = study.automatic_limits
    points = np.linspace(0.0, 1.0, 40)[:, None]
    found = flown_obstacle(study, limit, points, 2.0 - points[:, 0], [f"p{i:04d}" for i in range(40)])
    assert (found.reached, found.point, found.moved_by) == (1.0, "p0039", ["tilt.lambda"])
    (sentence,) = obstacle_texts([found])
    assert 'mission.followed moves it, mission.off = ["rms.position"] takes it away' in sentence
    assert "Searched gains that move it: tilt.lambda" in sentence
    # Values that have nothing to do with the gain.
    other = np.random.default_rng(5).permutation(points[:, 0]) + 1.0
    assert flown_obstacle(study, limit, points, other, found.point * 40).moved_by == []


def test_plan_tells_them(tmp_path, monkeypatch, capsys):
    code, out, _ = tuner(monkeypatch, capsys, "plan", write(tmp_path, STUDY), "--json")
    assert code == 0
    (row,) = json.loads(out)["automatic_limits"]
    assert row["label"] == LABEL and row["key"] == "mission.followed"
