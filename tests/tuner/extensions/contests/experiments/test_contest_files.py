"""Contest files: what is merged over what, dotted keys, and what the contest then is."""

import tomllib
from pathlib import Path
from typing import Any

import pytest

import plant.quadrotor.airframes
from plant.errors import InputError
from plant.quadrotor.airframes import load
from tests.tuner.extensions.contests.experiments.contest_text import CONTEST, NAMES, changed, write
from tests.tuner.study.loading import load_contest
from tuner.extensions.contests.reading import slug_of
from tuner.study.build import study_from_table
from tuner.study.kinds import kind_of_layers
from tuner.study.layers import merged, read_layers
from tuner.study.study import Study
from tuner.text.toml_text import toml_text

SHARED, OWN = CONTEST.split('[[contender]]\nname = "PID"', 1)
TOP = 'title = "On top"\nbase = "shared.toml"\n'


def gains_of(contest, index):
    resolved: dict[str, Any] = contest.contenders[index].study.resolved()
    return resolved["gains"]


def airframe_of(contender):
    """The airframe of a contender that flies a quadrotor."""
    assert isinstance(contender.study, Study)
    return contender.study.airframe


def test_a_contender_is_the_base_study_with_its_own_tables_on_top(tmp_path):
    contest = load_contest(write(tmp_path))
    pid, hybrid, ladrc = contest.contenders
    assert [entry.name for entry in contest.contenders] == NAMES
    assert [entry.slug for entry in contest.contenders] == ["pid", "the-hybrid-v1-0", "ladrc"]
    assert [entry.study.system.laws["attitude"].name for entry in contest.contenders] == ["pid", "hybrid", "ladrc"]
    assert [entry.study.system.laws["position"].name for entry in contest.contenders] == ["pid", "ladrc", "ladrc"]
    assert [airframe_of(entry).name for entry in contest.contenders] == ["hummingbird", "hummingbird", "f450"]
    assert [entry.tuned for entry in contest.contenders] == [True, False, False]
    assert pid.study.title == "Test: PID"
    assert contest.title == "Test"
    for other in (hybrid, ladrc):
        assert other.study.scenarios == pid.study.scenarios
        assert other.study.objectives == pid.study.objectives
        assert other.study.seed == pid.study.seed == contest.seed == 3


def test_gains_of_the_base_are_inherited_whole_or_not_at_all(tmp_path):
    contest = load_contest(write(tmp_path))
    assert gains_of(contest, 1)["roll.lambda"] == 7.0
    # PID gives gains, so the base's lambda, a gain that PID has not, does not reach it.
    assert gains_of(contest, 0)["roll.kd"] == 14.0


def test_quantities_are_those_of_the_study_then_of_cells_and_claims_each_once(tmp_path):
    contest = load_contest(write(tmp_path))
    assert [(q.label, q.kind, q.limit) for q in contest.quantities] == [
        ("cvar50(itae.position)", "objective", None),
        ("mean(travel)", "objective", None),
        ("mean(failure)", "constraint", 0.0),
        ("quantile50(rms.position)@gusts", "constraint", 100.0),
        ("mean(peak.roll)@gusts", "published", None),
        ("mean(rms.yaw)", "claimed", None),
    ]
    (claim,) = contest.claims
    labels = [objective.label for objective in claim.objectives]
    assert labels == ["cvar50(itae.position)", "mean(peak.roll)@gusts", "mean(rms.yaw)"]
    assert [entry.fitted for entry in contest.published] == [False, True]


def test_an_objective_that_is_limited_too_stands_once_with_its_limit(tmp_path):
    text = changed('metric = "failure"\nmax = 0.0', 'metric = "travel"\nmax = 9.0')
    quantities = load_contest(write(tmp_path, text)).quantities
    assert [(q.kind, q.limit) for q in quantities if q.label == "mean(travel)"] == [("objective", 9.0)]


def test_claim_takes_a_label_or_every_quantity_of_a_metric_in_its_scenario(tmp_path):
    text = changed('"rms.yaw"]', '"mean(travel)"]\nscenario = "gusts"')
    (claim,) = load_contest(write(tmp_path, text)).claims
    # itae.position is judged pooled over scenarios; a claim about one scenario asks for its own.
    labels = [objective.label for objective in claim.objectives]
    assert labels == ["mean(itae.position)@gusts", "mean(peak.roll)@gusts", "mean(travel)"]


def test_base_is_merged_deep_lists_are_replaced_and_contenders_may_come_from_it(tmp_path):
    write(tmp_path, SHARED, "shared.toml")
    top = f'{TOP}[search]\ngenerations = 5\n[[objective]]\nmetric = "rms.position"\n[[contender]]\nname = "A"\n'
    contest = load_contest(write(tmp_path, top))
    study = contest.contenders[0].study
    assert contest.title == "On top"
    assert (study.search.generations, study.search.population) == (5, 8)
    assert [objective.label for objective in study.objectives] == ["mean(rms.position)"]
    assert gains_of(contest, 0)["yaw.lambda"] == 7.0
    deeper = write(tmp_path, 'base = "contest.toml"\nseed = 9\n', "deeper.toml")
    assert kind_of_layers(read_layers(deeper)).name == "contest"
    assert [entry.name for entry in load_contest(deeper).contenders] == ["A"]
    assert load_contest(deeper).seed == 9


def test_an_airframe_replaces_the_one_below(tmp_path):
    frame = (Path(plant.quadrotor.airframes.__file__).parent / "iris.toml").read_text()
    write(tmp_path, frame, "mine.toml")
    text = changed('airframe = { name = "f450" }', 'airframe = { file = "mine.toml" }')
    assert airframe_of(load_contest(write(tmp_path, text)).contenders[2]).title == load("iris").title
    write(tmp_path, SHARED, "shared.toml")
    top = f'{TOP}[airframe]\nfile = "mine.toml"\n[[contender]]\nname = "A"\n'
    assert airframe_of(load_contest(write(tmp_path, top)).contenders[0]).title == load("iris").title


def test_a_study_is_no_contest(tmp_path):
    assert kind_of_layers(read_layers(write(tmp_path, SHARED, "study.toml"))).name == "tuning"
    assert kind_of_layers(read_layers(write(tmp_path))).name == "contest"


def test_paths_of_a_base_are_relative_to_the_base(tmp_path):
    route = "t,x,y,z,yaw_deg\n0,0,0,0,0\n1,1,0,0,0\n"
    write(tmp_path, route, "shared/route.csv")
    text = changed('kind = "steps"\nx = 1.0\ntime = 0.2', 'kind = "waypoints"\npath = "route.csv"', SHARED)
    write(tmp_path, text, "shared/shared.toml")
    top = 'base = "../shared/shared.toml"\n[[contender]]\nname = "A"\n'
    contest = load_contest(write(tmp_path, top, "mine/contest.toml"))
    assert contest.contenders[0].study.scenarios[0].spec.reference.kind == "waypoints"


def test_merged_changes_neither_side():
    under, over = {"a": {"b": [1, 2], "c": 3}, "d": 4}, {"a": {"b": [9]}, "e": {"f": 5}}
    result: dict[str, Any] = merged(under, over)
    assert result == {"a": {"b": [9], "c": 3}, "d": 4, "e": {"f": 5}}
    result["a"]["b"].append(0)
    result["e"]["f"] = 0
    assert (under, over) == ({"a": {"b": [1, 2], "c": 3}, "d": 4}, {"a": {"b": [9]}, "e": {"f": 5}})


@pytest.mark.parametrize("who", ["contender.0", "contender[0]", "contender.PID"])
def test_overrides_reach_a_contender_by_number_and_name(tmp_path, who):
    changes = {f"{who}.search.generations": 7, f"{who}.gains.attitude.kp.low": 30.0, f"{who}.gains.roll.kd": 20.0}
    contest = load_contest(write(tmp_path), changes)
    study = contest.contenders[0].study
    assert study.search.generations == 7
    assert study.space.variables[0].low == 30.0
    assert (gains_of(contest, 0)["roll.kd"], gains_of(contest, 0)["yaw.kd"]) == (20.0, 14.0)
    assert contest.contenders[1].study.search.generations == 3


def test_overrides_by_a_name_with_dots_and_of_what_is_shared(tmp_path):
    changes = {
        "contender.The hybrid, v1.0.gains.attitude.k1": 1.5,
        "scenario.1.held_out": 12,
        "published[0].value": 0.5,
        "search.population": 10,
    }
    contest = load_contest(write(tmp_path), changes)
    assert gains_of(contest, 1)["roll.k1"] == 1.5
    assert [entry.held_out for entry in contest.scenarios] == [8, 12]
    assert contest.published[0].value == 0.5
    assert contest.contenders[0].study.search.population == 10
    table: dict[str, Any] = contest.table
    assert table["search"]["population"] == 10


def test_of_two_names_that_fit_the_longer_is_meant(tmp_path):
    text = changed('name = "LADRC"\nairframe', 'name = "PID.gains"\nairframe', CONTEST.split("[[published]]")[0])
    contest = load_contest(write(tmp_path, text), {"contender.PID.gains.gains.attitude.zeta": 0.7})
    assert gains_of(contest, 2)["roll.zeta"] == 0.7


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ("contender.3.search.generations", "allowed: 0 to 2"),
        ("contender.PIDD.search.generations", "did you mean 'PID'"),
        ("contender.PID", "none of its keys"),
        ("contender.PID.name.x", "is a value, not a table"),
        ("scenario.7.held_out", "allowed: 0 to 1"),
    ],
)
def test_overrides_that_reach_nothing(tmp_path, key, words):
    with pytest.raises(InputError, match=words) as caught:
        load_contest(write(tmp_path), {key: 1})
    assert caught.value.key == key


def test_the_content_of_a_contender_is_a_study_of_its_own(tmp_path):
    contest = load_contest(write(tmp_path))
    for contender in contest.contenders:
        again = study_from_table(contest.path, tomllib.loads(toml_text(contender.raw)))
        assert again.digest() == contender.study.digest()


def test_toml_text_reads_back_as_the_same_table():
    table = {
        "text": 'a "quoted" \\ line\nbreak\ttab \x7f é',
        "empty": "",
        "flag": True,
        "whole": -3,
        "number": 1e-300,
        "list": [1.0, 0.1 + 0.2, 1e22],
        "none": [],
        "inner": {"a key": 1, "dotted.key": {"low": 0.5}, "empty": {}},
        "tables": [{"name": "a", "deep": {"x": 1, "rows": [{"y": 2}, {"y": 3}]}}, {"name": "b"}],
    }
    assert tomllib.loads(toml_text(table)) == table


def test_slugs_are_plain():
    assert [slug_of(name) for name in ("A-ST-SMC (printed)", "  PID  ", "é", "K1/K2")] == [
        "a-st-smc-printed",
        "pid",
        "",
        "k1-k2",
    ]
