"""Documents, tables, every --json and every --help of small runs are what they were.

The outputs are kept in `kept/`. What changes on purpose changes there, in a commit of its own:
`python -m tests.golden.write` writes them anew and prints each difference as `path.to.key: old -> new`.
What belongs to a machine is masked by the table `MASKED` of `made.py`; numbers agree to 1e-6.
"""

import pytest

from tests.golden.comparing import ADVICE, KEPT, differences, encoded, folded, kept, kept_names
from tests.golden.made import commands_with_json, documents, help_texts
from tests.golden.steps import SLOW_STEPS, STEPS

NAMES = kept_names()
SLOW = {f"json/{step.name}.json" for step in SLOW_STEPS}
QUICK = [name for name in NAMES if name not in SLOW]


@pytest.fixture(scope="session")
def made(tmp_path_factory):
    return {**help_texts(), **documents(tmp_path_factory.mktemp("golden") / "work", STEPS)}


def assert_kept(name, new):
    lines = list(differences(kept(name), new))
    if lines:
        pytest.fail("\n".join([f"{name} has changed:", *lines, ADVICE]), pytrace=False)


@pytest.mark.parametrize("name", QUICK)
def test_the_output_is_what_was_kept(name, made):
    assert name in made, f"{name} is not written any more. {ADVICE}"
    assert_kept(name, made[name])


def test_every_output_is_kept(made):
    assert sorted(made) == QUICK, ADVICE


def test_what_is_kept_is_folded_without_loss():
    whole = {name: kept(name) for name in NAMES}
    again = folded(whole)
    assert {name: encoded(again[name]) for name in NAMES} == {
        name: (KEPT / name).read_text(encoding="utf-8") for name in NAMES
    }


def test_every_command_with_json_is_run():
    run = {step.arguments[0] for step in (*STEPS, *SLOW_STEPS)}
    assert commands_with_json() - run == set(), f"give it a step in tests/golden/steps.py. {ADVICE}"


@pytest.mark.slow
def test_the_speeds_are_told_as_before(tmp_path):
    for name, new in documents(tmp_path / "work", SLOW_STEPS).items():
        assert_kept(name, new)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ({"a": {"b": 1.0}}, {"a": {"b": 1.0000001}}, []),
        ({"a": {"b": 1.0}}, {"a": {"b": 57.3}}, ["a.b: 1.0 -> 57.3"]),
        ({"a": 1.0}, {"c": 1.0}, ['a: 1.0 -> "(nothing)"', 'c: "(nothing)" -> 1.0']),
        ({"a": [1, 2]}, {"a": [1]}, ['a[1]: 2 -> "(nothing)"']),
        ({"a": True}, {"a": 1}, ["a: true -> 1"]),
        ({"a": None}, {"a": 0.0}, ["a: null -> 0.0"]),
        ({"a": "12.0 deg"}, {"a": "12.0 rad"}, ['a: "12.0 deg" -> "12.0 rad"']),
        ({"a": "12.0 deg"}, {"a": "12.00000001 deg"}, []),
        ({"a": float("nan")}, {"a": float("nan")}, []),
    ],
)
def test_a_difference_is_told_by_its_path(old, new, told):
    assert list(differences(old, new)) == told
