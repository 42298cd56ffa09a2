"""Old names of keys: read as the new ones with one warning, refused beside them, silent in the record of a run."""

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from plant.errors import InputError
from tests.tuner.extensions.contests.experiments.contest_text import CONTEST
from tests.tuner.extensions.contests.experiments.contest_text import write as write_named
from tests.tuner.in_process import tuner
from tests.tuner.study.study_text import STUDY, changed, write
from tuner.study.build import load_study
from tuner.study.files import SHIPPED
from tuner.study.kinds import load_any
from tuner.study.renamed import GONE, NAMES
from tuner.text.errors import RenamedKeyWarning

MARGINS = """
[[margin]]
quantity = "phase_margin"
axis = "tilt"
min = 5

[[guarantee]]
theorem = "ultimate_error"
axis = "tilt"
max = 10.0

[[cost]]
quantity = "instructions"
max = 1e5
"""
NEW = STUDY + MARGINS
OLD = NEW.replace("max = ", "most = ").replace("min = ", "least = ")
BOTH = changed("max = 0.0", "max = 0.0\nmost = 0.0")


def test_old_names_are_the_same_study_and_are_named_in_one_warning(tmp_path):
    new = load_study(write_named(tmp_path, NEW, "new.toml"))
    file = write_named(tmp_path, OLD, "old.toml")
    with pytest.warns(RenamedKeyWarning) as told:
        old = load_study(file)
    assert [str(entry.message) for entry in told] == [
        f"{file}: constraint[0].most, margin[0].least, guarantee[0].most, cost[0].most: write max and min; version 0.3 "
        "does not read the old name"
    ]
    assert old.digest() == new.digest()
    assert old.resolved() == new.resolved()


def test_the_page_on_what_may_change_says_when_they_go():
    page = (Path(__file__).parents[3] / "docs" / "stability.md").read_text(encoding="utf-8")
    assert f"{GONE} does not read them" in page and all(f"`{name}`" in page for name in (*NAMES, *NAMES.values()))


def test_recorded_values_keep_the_names_of_the_first_recorded_runs(tmp_path):
    resolved: dict[str, Any] = load_study(write(tmp_path, NEW)).resolved()
    assert [
        set(resolved[key][0]) & {"most", "least", "max", "min"} for key in ("constraint", "margin", "guarantee", "cost")
    ] == [
        {"most"},
        {"most", "least"},
        {"most", "least"},
        {"most"},
    ]


def test_a_study_that_a_run_recorded_is_read_without_a_word(tmp_path):
    inputs = tmp_path / "inputs"
    inputs.mkdir()
    (tmp_path / "run.json").write_text("{}", encoding="utf-8")
    assert load_study(write(inputs, OLD)).constraints[0].most == 0.0


@pytest.mark.parametrize(
    ("key", "value"),
    [("constraint.0.most", 0.5), ("constraint[0].most", 0.5), ("constraint", [{"metric": "failure", "most": 0.5}])],
)
def test_old_names_are_read_in_overrides(key, value, tmp_path):
    with pytest.warns(RenamedKeyWarning, match="constraint.*most: write max; version 0.3"):
        assert load_study(write(tmp_path, STUDY), {key: value}).constraints[0].most == 0.5


def test_a_new_name_on_the_command_line_replaces_an_old_one_of_the_file(tmp_path):
    with pytest.warns(RenamedKeyWarning):
        assert load_study(write(tmp_path, OLD), {"constraint.0.max": 0.5}).constraints[0].most == 0.5


def test_old_names_are_read_in_a_contest(tmp_path):
    new = load_any(write_named(tmp_path))
    with pytest.warns(RenamedKeyWarning, match="most: write max"):
        old = load_any(write_named(tmp_path, CONTEST.replace("\nmax = ", "\nmost = "), "old.toml"))
    assert old.digest() == new.digest()


def test_the_error_that_loses_a_flight_was_called_limit(tmp_path):
    shipped = SHIPPED / "dc_motor.toml"
    shutil.copy(shipped.with_name("dc_motor.py"), tmp_path)
    text = shipped.read_text(encoding="utf-8")
    file = write_named(tmp_path, text.replace("lost_beyond = 10.0", "limit = 10.0"), "old.toml")
    with pytest.warns(RenamedKeyWarning, match=r"channel\[0\].limit: write lost_beyond; version 0.3"):
        old: Any = load_any(file)
    new: Any = load_any(write_named(tmp_path, text, "new.toml"))
    assert old.system.plan.channels[0].limit == 10.0
    assert old.digest() == new.digest() and new.resolved()["channel"][0]["limit"] == 10.0
    with pytest.warns(RenamedKeyWarning, match="channel.0.limit: write lost_beyond"):
        changed_alone: Any = load_any(shipped, {"channel.0.limit": 9.0})
    assert changed_alone.system.plan.channels[0].limit == 9.0


def test_both_names_are_refused(tmp_path):
    file = write(tmp_path, BOTH)
    with pytest.raises(InputError, match="old name of max, which is given too; leave one out") as caught:
        load_study(file)
    assert (caught.value.file, caught.value.key) == (str(file), "constraint[0].most")


@pytest.mark.filterwarnings("default")
def test_the_command_line_says_it_in_one_line_beside_its_json(tmp_path, monkeypatch, capsys):
    file = write(tmp_path, changed("max = 0.0", "most = 0.0"))
    code, out, err = tuner(monkeypatch, capsys, "check", file, "--json")
    assert code == 0 and json.loads(out)
    assert err == f"Warning: {file}: constraint[0].most: write max; version 0.3 does not read the old name\n"
