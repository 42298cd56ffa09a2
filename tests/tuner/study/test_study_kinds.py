"""Study files of every kind come through one door, each read once."""

import pytest

from plant.errors import InputError
from tests.tuner.extensions.contests.experiments import contest_text
from tests.tuner.study.study_text import STUDY, write
from tuner.extensions.contests.study import Contest
from tuner.study import layers
from tuner.study.files import shipped_studies
from tuner.study.kinds import kind_of_layers, load_any, load_tuning, study_kinds
from tuner.study.layers import read_layers
from tuner.study.study import Study

TYPES = {"tuning": Study, "contest": Contest}


def test_every_kind_has_a_name_of_its_own_and_the_last_takes_all_files():
    assert [kind.name for kind in study_kinds()] == ["choices", "contest", "trials", "plant", "tuning"]
    assert [kind.table for kind in study_kinds()] == ["choices", "contender", "trials", "plant", None]


@pytest.mark.parametrize("name", ["quickstart", "contest", "paper_table3"])
def test_a_shipped_study_becomes_what_its_tables_say_and_is_parsed_once(name, monkeypatch):
    path, parsed = shipped_studies()[name], []
    parse = layers.parse_toml
    monkeypatch.setattr(layers, "parse_toml", lambda file: parsed.append(file) or parse(file))
    study = load_any(path)
    assert len(parsed) == len(set(parsed)) >= 1
    kind = kind_of_layers(read_layers(path)).name
    assert type(study) is TYPES[kind] and study.kind == kind
    assert study.path == path and study.title and isinstance(study.seed, int) and getattr(study, "content", None)


def test_overrides_reach_every_kind(tmp_path):
    tuning = load_any(write(tmp_path, STUDY), {"search.generations": 7})
    assert isinstance(tuning, Study) and tuning.generations == 7
    name = "LADRC"
    contest = load_any(contest_text.write(tmp_path), {"title": "Other", f"contender.{name}.pick.rule": "closest"})
    assert isinstance(contest, Contest) and contest.title == "Other" and contest.generations is None
    assert next(entry for entry in contest.contenders if entry.name == name).study.pick == "closest"


def test_a_command_for_one_controller_names_itself_and_the_table_that_it_cannot_take(tmp_path):
    with pytest.raises(InputError, match="this is a contest; `tuner plan` takes a study of one controller") as caught:
        load_tuning(contest_text.write(tmp_path), "tuner plan")
    assert caught.value.key == "contender"
    assert load_tuning(write(tmp_path, STUDY), "tuner plan").kind == "tuning"
