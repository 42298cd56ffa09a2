"""`[choices]`: combinations of a study as contenders that race by successive halving."""

import pytest

from plant.errors import InputError, UnknownNameError
from tests.tuner.extensions.contests.experiments.contest_text import CONTEST
from tests.tuner.study.loading import load_contest
from tests.tuner.study.study_text import STUDY
from tuner.extensions.contests.study import Contest, HalvingSchedule
from tuner.study.kinds import load_any
from tuner.study.plant_study import PlantStudy
from tuner.study.study import Study
from tuner.text.toml_text import toml_text

GAINS = """
[choices]
"controller.attitude" = ["hybrid", "ladrc", "pid"]
"controller.attitude_rate" = ["measured", "observer"]
"""
SEARCHED = {
    "tilt.lambda": {"low": 1.0, "high": 16.0},
    "tilt.omega_c": {},
    "tilt.omega_o": {},
    "tilt.kp": {},
    "yaw.kp": 20.0,
}
MOTOR = """
base = "dc_motor.toml"
title = "Law of the motor"
seed = 3

[choices]
"channel.angle" = [{ law = "pid", b0 = 2122.0 }, { law = "ladrc", b0 = 2122.0 }]
"channel.angle.every" = [1, 2]

[gains]
"angle.kp" = { low = 2000.0, high = 120000.0, default = 20000.0 }
"angle.ki" = 1000.0
"angle.kd" = 40.0
"angle.t_f" = 0.001
"angle.omega_c" = { low = 10.0, high = 400.0 }
"angle.zeta" = 1.0
"angle.omega_o" = 150.0
"""


def loaded(tmp_path, changes=None, text=STUDY + GAINS):
    file = tmp_path / "choices.toml"
    file.write_text(text)
    study = load_any(file, {"gains": SEARCHED, **(changes or {})})
    assert isinstance(study, Contest)
    return study


def test_every_combination_is_a_contender_with_the_gains_of_its_laws(tmp_path):
    contest = loaded(tmp_path)
    assert [entry.name for entry in contest.contenders] == [
        f"{law} / {rate}" for law in ("hybrid", "ladrc", "pid") for rate in ("measured", "observer")
    ]
    searched = {entry.name: [each.name for each in entry.study.space.variables] for entry in contest.contenders}
    assert searched["hybrid / observer"] == ["tilt.lambda", "tilt.omega_o"]
    assert searched["ladrc / measured"] == ["tilt.omega_c", "tilt.omega_o"]
    assert searched["pid / measured"] == ["tilt.kp"]
    for entry in contest.contenders:
        assert isinstance(entry.study, Study)
        law, rate = entry.name.split(" / ")
        assert (entry.study.system.cascade.attitude.name, entry.study.options.attitude_rate) == (law, rate)
    assert contest.halving == HalvingSchedule(factor=3, finalists=1, least=4)


def test_searches_with_starts_race_from_the_second_generation_on(tmp_path):
    start = {"search.starts": [{"points": [{"tilt.omega_o": 20.0}]}]}
    contest = loaded(
        tmp_path, {**start, "gains": {"tilt.omega_o": {}}, "choices": {"controller.attitude": ["hybrid", "ladrc"]}}
    )
    assert contest.halving is not None and contest.halving.least == 2
    assert contest.halving_texts == ["Successive halving: 2 to 2 generations, 1 to 2."]
    assert loaded(tmp_path, {"halving.least": 3}).halving == HalvingSchedule(factor=3, finalists=1, least=3)


def test_channels_of_a_plant_are_chosen_by_name(tmp_path):
    contest = load_contest(written(tmp_path, MOTOR))
    studies = [entry.study for entry in contest.contenders]
    channels = [study.system.plan.channel("angle") for study in studies if isinstance(study, PlantStudy)]
    assert [(each.law.name, each.every, each.b0) for each in channels] == [
        ("pid", 1, 2122.0), ("pid", 2, 2122.0), ("ladrc", 1, 2122.0), ("ladrc", 2, 2122.0),
    ]  # fmt: skip
    assert [entry.name for entry in contest.contenders] == [
        "pid / every 1", "pid / every 2", "ladrc / every 1", "ladrc / every 2",
    ]  # fmt: skip
    assert [each.name for each in contest.contenders[3].study.space.variables] == ["angle.omega_c"]


def written(folder, text):
    file = folder / "choices.toml"
    file.write_text(text)
    return file


def test_the_content_is_the_contest_that_it_is(tmp_path):
    contest = loaded(tmp_path)
    again = load_contest(written(tmp_path, toml_text(contest.content)))
    assert again.digest() == contest.digest() and again.halving == contest.halving
    assert "choices" not in contest.content


def test_the_digest_has_the_halving(tmp_path):
    assert loaded(tmp_path).digest() != loaded(tmp_path, {"halving.finalists": 2}).digest()


def test_choices_may_be_written_as_nested_tables(tmp_path):
    nested = '\n[choices.controller]\nattitude = ["hybrid", "ladrc"]\ndelay = [false, true]\n'
    names = [entry.name for entry in loaded(tmp_path, {"gains": {"tilt.omega_o": {}}}, STUDY + nested).contenders]
    assert names == ["hybrid / delay false", "hybrid / delay true", "ladrc / delay false", "ladrc / delay true"]


LAMBDA = {"tilt.lambda": {}}
WRONG = [
    ({"choices": {"controller.attitude": ["pid"]}}, "choices.controller.attitude", "write two values or more"),
    ({"choices": {"controller.attitude": "pid"}}, "choices.controller.attitude", "write two values or more"),
    ({"choices": {"controller.attitude": ["pid", "pid"]}}, "choices.controller.attitude", "given a value twice"),
    ({"choices": {"limits.position": [1.0, 2.0]}}, "choices.limits.position", "allowed: airframe.KEY, controller.KEY"),
    ({"choices": {"search.population": [8, 16]}}, "choices.search.population", "is not to be chosen"),
    (
        {"choices": {"controller.attitud": ["pid", "hybrid"]}, "gains": LAMBDA},
        "contender[0].controller.attitud",
        "did you mean 'attitude'",
    ),
    (
        {"choices": {"controller.attitude": ["pid", "hybird"]}},
        "contender[1].controller.attitude",
        "did you mean 'hybrid'",
    ),
    ({"choices": {"controller.rpm_notches": list(range(65))}}, "choices", "given 65 combinations; allowed: up to 64"),
    (
        {"choices": {"controller.control_period": [0.004, 0.002]}, "gains": LAMBDA},
        "contender[0].controller.control_period",
        "is the same for all",
    ),
    ({"gains": {**SEARCHED, "tilt.kq": {}}}, "gains.tilt.kq", "unknown gain of any choice 'kq'"),
    ({"gains": {"yaw.kp": 20.0, "tilt.lambda": {}}}, "halving", "nothing is searched for 'ladrc / measured'"),
    ({"halving.finalists": 6}, "halving.finalists", "allowed: fewer than the 6 contenders"),
    ({"halving.factor": 1}, "halving.factor", "at least 2"),
    ({"halving.fact": 2}, "halving.fact", "did you mean 'factor'"),
]


@pytest.mark.parametrize(("changes", "key", "message"), WRONG)
def test_wrong_choices_are_refused_in_a_sentence(tmp_path, changes, key, message):
    with pytest.raises(InputError) as refused:
        loaded(tmp_path, changes)
    assert refused.value.key == key and message in str(refused.value)


def test_an_unknown_channel_is_the_error_of_names(tmp_path):
    with pytest.raises(UnknownNameError, match="did you mean 'angle'"):
        load_any(written(tmp_path, MOTOR.replace('"channel.angle.every"', '"channel.angel.every"')))


def test_contenders_and_choices_do_not_stand_together(tmp_path):
    with pytest.raises(InputError, match="whose combinations are the contenders"):
        load_any(written(tmp_path, CONTEST + GAINS))


def test_claims_cannot_be_about_contenders_that_may_be_dropped(tmp_path):
    with pytest.raises(InputError, match="cannot be dropped; leave \\[halving\\] out"):
        load_any(written(tmp_path, CONTEST), {"halving": {}})


def test_rungs_take_a_third_of_six_full_searches():
    halving = HalvingSchedule(factor=3, finalists=1, least=2)
    rungs = halving.rungs(6)
    assert [rung.contenders for rung in rungs] == [6, 2]
    assert [halving.generations(rung, 12) for rung in rungs] == [2, 4]
    # 4 stop after 2 generations, one after 4, one goes to 12.
    assert halving.flights_at_most([(12, 96)] * 6) == 96 * (4 * 2 + 4 + 12) == 96 * 6 * 12 // 3


@pytest.mark.parametrize(("contenders", "finalists"), [(2, 1), (7, 2), (9, 1), (64, 3)])
def test_rungs_end_at_the_finalists(contenders, finalists):
    halving = HalvingSchedule(factor=3, finalists=finalists, least=1)
    rungs = halving.rungs(contenders)
    sizes = [rung.contenders for rung in rungs] + [finalists]
    assert sizes[0] == contenders and all(a > b for a, b in zip(sizes, sizes[1:], strict=False))
    assert all(b >= a / 3 for a, b in zip(sizes, sizes[1:], strict=False))
    assert [rung.share for rung in rungs] == [3.0 ** (i - len(rungs)) for i in range(len(rungs))]
