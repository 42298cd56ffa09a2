"""The verdict of a second opinion on made-up evidence: each reason by itself, its limits, and what an unknown vehicle allows."""

import pytest

from tuner.documents.assessment import (
    AssessedAirframe,
    AssessedLoop,
    AssessedMetric,
    AssessedScenario,
    AssessmentDocument,
    LoopFigures,
    RuleRow,
)
from tuner.documents.parts import SampledValue, ShareCount
from tuner.documents.verdicts import verdict_on_difference
from tuner.extensions.judge.opinion import Evidence, form_opinion, metric_text, opinion_sentence
from tuner.report.opinion_section import rule_table


def figures(ms):
    return LoopFigures(stable=ms is not None, gain_up=None, gain_down=None, phase_margin=None, delay_margin=None, ms=ms)


def loop(after, before=None, given=True):
    return AssessedLoop(channel="roll", before=figures(before) if given else None, after=figures(after))


def metric(name, *difference, scenario=None):
    interval = SampledValue(*difference)
    return AssessedMetric(
        metric=name, scenario=scenario, definition="", unit="1", before=1.0, after=1.0 + interval.value, difference=interval,
        verdict=verdict_on_difference(1.0, interval),
    )  # fmt: skip


def count(events, flights=256):
    return ShareCount(events=events, flights=flights, upper=0.012)


def lost(after=0, before: int | None = 0, loss: str | None = "not distinguishable", name="small steps"):
    earlier = None if before is None else count(before)
    return AssessedScenario(name=name, flights=256, lost_after=count(after), lost_before=earlier, loss=loss)


def rule(verdict="violated", refuses=True):
    return RuleRow(
        rule="a filter", source="its tool", axis="roll", value=2.0, limit=1.0, unit="1", sense="max", verdict=verdict,
        refuses=refuses, note="",
    )  # fmt: skip


def evidence(known=True, **parts):
    airframe = AssessedAirframe(name="x", title="class of a racer", is_known=known, ranges="mass 0.4 to 0.9 kg")
    usual = {
        "loops": [loop(1.6, 1.6)],
        "violated": [],
        "rules": [],
        "metrics": [metric("rms.tilt", 0.0, -0.03, 0.03)],
        "scenarios": [lost()],
        "unmodeled": 0,
    }
    return Evidence(airframe=airframe, **{**usual, **parts})


ALONE = {"scenarios": [lost(0, None, None)], "metrics": []}
TORQUE = metric("rms.tilt", 1.3, 1.2, 1.4, scenario="torque step")
DRIFT = metric("rms.position", 1.29, 1.2, 1.4)
CASES = {
    "less noise, and the position drifts by twice as much": (
        {"metrics": [metric("noise", -0.0465, -0.05, -0.04), DRIFT]}, "worse",
    ),
    "less noise, and the position perhaps drifts by twice as much": (
        {"metrics": [metric("noise", -0.0465, -0.05, -0.04), metric("rms.position", 1.1, 0.9, 1.3)]}, "quieter and softer",
    ),
    "twice the noise, and the position drifts less": (
        {"metrics": [metric("noise", 1.29, 1.2, 1.4), metric("rms.position", -0.2, -0.25, -0.15)]}, "stiffer and louder",
    ),
    "six times the noise, and a third less error in yaw": (
        {"metrics": [metric("noise", 5.415, 5.364, 5.466), metric("rms.yaw", -0.356, -0.366, -0.345)]}, "worse",
    ),
    "five times the gain, five times the noise, and a fifth of the error after a torque": (
        {"metrics": [metric("noise", 4.0, 3.9, 4.1), metric("rms.tilt", -0.8, -0.81, -0.79, scenario="torque step")]},
        "stiffer and louder",
    ),
    "perhaps four times the noise, and hardly less error": (
        {"metrics": [metric("noise", 2.8, 2.2, 3.4), metric("rms.tilt", -0.05, -0.06, -0.04)]}, "stiffer and louder",
    ),
    "four times the noise, and hardly less error": (
        {"metrics": [metric("noise", 2.8, 2.5, 3.1), metric("rms.tilt", -0.05, -0.06, -0.04)]}, "worse",
    ),
    "twice the noise, and hardly less error": (
        {"metrics": [metric("noise", 1.2, 1.1, 1.3), metric("rms.tilt", -0.05, -0.06, -0.04)]}, "stiffer and louder",
    ),
    "nothing changes": ({}, "not distinguishable"),
    "attitude follows closer": ({"metrics": [metric("rms.tilt", -0.2, -0.25, -0.15)]}, "better"),
    "attitude follows a little closer": ({"metrics": [metric("rms.tilt", -0.06, -0.08, -0.04)]}, "better"),
    "attitude follows closer by nothing that matters": (
        {"metrics": [metric("rms.tilt", -0.01, -0.015, -0.005)]}, "no practical difference",
    ),
    "as much noise as before, attitude open": (
        {"metrics": [metric("noise", 0.0, -0.01, 0.01), metric("rms.tilt", 0.0, -0.03, 0.03)]}, "not distinguishable",
    ),
    "less noise, and attitude a little worse": (
        {"metrics": [metric("noise", -0.287, -0.29, -0.28), metric("rms.tilt", 0.0485, 0.047, 0.05)]}, "quieter and softer",
    ),
    "less noise, and a torque turns the vehicle further": (
        {"metrics": [metric("noise", -0.287, -0.29, -0.28), metric("rms.tilt", 0.01, 0.0, 0.015), TORQUE]}, "quieter and softer",
    ),
    "closer in the breeze, and a torque turns the vehicle further": (
        {"metrics": [metric("noise", 0.0, -0.01, 0.01), metric("rms.tilt", -0.1, -0.11, -0.09), TORQUE]}, "mixed",
    ),
    "noise": ({"metrics": [metric("noise", 0.3, 0.29, 0.31)]}, "worse"),
    "a little noise": ({"metrics": [metric("noise", 0.08, 0.07, 0.09)]}, "worse"),
    "a trade": ({"metrics": [metric("noise", 0.3, 0.2, 0.4), metric("rms.tilt", -0.3, -0.4, -0.2)]}, "stiffer and louder"),
    "unstable": ({"loops": [loop(None, 1.6)]}, "do not fly"),
    "unstable before too": ({"loops": [loop(None, None)]}, "do not fly"),
    "fragile now": ({"loops": [loop(2.1, 1.6)]}, "do not fly"),
    "fragile, and was": ({"loops": [loop(2.1, 2.05)]}, "not distinguishable"),
    "within 2": ({"loops": [loop(1.99, 1.2)]}, "not distinguishable"),
    "very fragile, and was": ({"loops": [loop(4.5, 4.5)]}, "do not fly"),
    "less fragile": ({"loops": [loop(2.5, 4.0)]}, "not distinguishable"),
    "sound, and was not to be flown": ({"loops": [loop(1.33, 4.45)]}, "better"),
    "sound, and was unstable": ({"loops": [loop(1.33, None)]}, "better"),
    "sound, and was not, at a price": ({"loops": [loop(1.33, 4.45)], "metrics": [metric("rms.tilt", 0.1, 0.09, 0.11)]}, "mixed"),
    "sound, and was not, quieter": (
        {"loops": [loop(1.33, 4.45)], "metrics": [metric("noise", -0.3, -0.31, -0.29), TORQUE]}, "quieter and softer",
    ),
    "not yet sound": ({"loops": [loop(2.1, 4.45)]}, "not distinguishable"),
    "a rule refuses": ({"rules": [rule()]}, "do not fly"),
    "a rule advises": ({"rules": [rule(refuses=False)]}, "not distinguishable"),
    "more losses": ({"scenarios": [lost(9, 0, "worse")]}, "do not fly"),
    "more losses in a gust": ({"scenarios": [lost(), lost(9, 0, "worse", "gust")]}, "do not fly"),
    "as many losses": ({"scenarios": [lost(9, 9)]}, "do not fly"),
    "one loss": ({"scenarios": [lost(1)]}, "not distinguishable"),
    "alone": (ALONE | {"loops": [loop(1.6, given=False)]}, "flyable within limits"),
    "alone and fragile": (ALONE | {"loops": [loop(4.4, given=False)]}, "do not fly"),
    "alone with a violated rule": (ALONE | {"loops": [loop(1.6, given=False)], "rules": [rule(refuses=False)]}, "no objection"),
    "alone with a loss": (ALONE | {"scenarios": [lost(1, None, None)], "loops": [loop(1.6, given=False)]}, "no objection"),
    "alone with a loss in a gust": (
        ALONE | {"scenarios": [lost(0, None, None), lost(1, None, None, "gust")], "loops": [loop(1.6, given=False)]}, "no objection",
    ),
    "alone, vehicle unknown": (ALONE | {"known": False, "loops": [loop(1.6, given=False)]}, "no objection"),
    "vehicle unknown, fragile in its middle": (ALONE | {"known": False, "loops": [loop(4.4, given=False)]}, "not judged"),
    "vehicle unknown, unstable in its middle": (ALONE | {"known": False, "loops": [loop(None, given=False)]}, "do not fly"),
    "vehicle unknown, as fragile as before": ({"known": False, "loops": [loop(9.0, 9.0)]}, "not distinguishable"),
    "vehicle unknown, made fragile": ({"known": False, "loops": [loop(3.0, 1.5)]}, "do not fly"),
    "vehicle unknown, a tenth lost": ({"known": False, "scenarios": [lost(27, 27)]}, "not distinguishable"),
    "vehicle unknown, most lost": ({"known": False, "scenarios": [lost(200, 200)]}, "do not fly"),
}  # fmt: skip


@pytest.mark.parametrize(("parts", "verdict"), CASES.values(), ids=CASES)
def test_a_verdict_follows_from_the_evidence(parts, verdict):
    given = evidence(**parts)
    word, reasons = form_opinion(given)
    sentence = opinion_sentence(given, word, reasons)
    assert word == verdict and sentence.lower().startswith(verdict)
    assert "safe" not in sentence.lower()
    assert ("mass 0.4 to 0.9 kg" in sentence) == (not given.airframe.is_known)


TRADE = [metric("noise", 0.3, 0.2, 0.4), metric("rms.tilt", -0.3, -0.4, -0.2)]
COMPARISONS = {
    "as before": ({}, "not distinguishable"),
    "a trade": ({"metrics": TRADE}, "stiffer and louder"),
    "closer": ({"metrics": TRADE[1:]}, "better"),
    "noisier": ({"metrics": TRADE[:1]}, "worse"),
    "survivors fly closer, and more are lost": ({"metrics": TRADE[1:], "scenarios": [lost(loss="worse")]}, "worse"),
    "survivors are noisier, and fewer are lost": (
        {"metrics": TRADE[:1], "scenarios": [lost(loss="better")]}, "better",
    ),
    "fewer are lost in the breeze, and more in a gust": (
        {"scenarios": [lost(loss="better"), lost(loss="worse", name="gust")]}, "mixed",
    ),
    "a loop recovers": ({"loops": [loop(1.33, 4.45)]}, "not distinguishable"),
    "a fragile loop flies closer": ({"loops": [loop(3.0, 1.5)], "metrics": TRADE[1:]}, "better"),
    "alone": (ALONE, None),
}  # fmt: skip


@pytest.mark.parametrize(("parts", "comparison"), COMPARISONS.values(), ids=COMPARISONS)
def test_a_comparison_is_of_paired_flights_alone(parts, comparison):
    assert evidence(**parts).comparison == comparison


def test_a_refusal_says_what_the_flights_do():
    given = evidence(loops=[loop(3.0, 1.5)], metrics=TRADE)
    sentence = opinion_sentence(given, *form_opinion(given))
    assert sentence.startswith(
        "Do not fly: peak sensitivity Ms, roll: 3, max 2 (1.5 before); in flight: stiffer and louder: noise +30 %"
    )
    assert sentence.endswith("lost 0 of 256: at most 1.2 % (before: 0 of 256: at most 1.2 %).")
    alone = evidence(**ALONE, loops=[loop(4.4, given=False)])
    assert "in flight" not in opinion_sentence(alone, *form_opinion(alone))


def test_a_sentence_names_the_scenario_of_a_mean_and_of_lost_flights():
    given = evidence(metrics=[TORQUE], scenarios=[lost(), lost(1, 0, name="gust")])
    sentence = opinion_sentence(given, *form_opinion(given))
    assert "rms.tilt (torque step) +130 % [120, 140]" in sentence
    assert sentence.endswith("lost (gust) 1 of 256 (before: 0 of 256: at most 1.2 %).")


def test_a_sentence_names_changes_outside_of_the_model():
    given = evidence(unmodeled=2)
    assert "without 2 changed parameters outside the model" in opinion_sentence(given, *form_opinion(given))


def test_a_rule_and_the_loop_that_it_is_about_are_one_reason():
    _, reasons = form_opinion(evidence(loops=[loop(3.0, 1.5)], rules=[rule()]))
    assert len(reasons) == 1


def test_the_table_of_rules_has_units():
    rows = [rule().model_copy(update={"unit": "deg", "value": 25.0, "limit": 30.0, "sense": "min"}), rule()]
    table = rule_table(AssessmentDocument.model_construct(rules=rows), violated=False)
    assert [row[2:4] for row in table.rows] == [["25 deg", "min 30 deg"], ["2", "max 1"]]


@pytest.mark.parametrize(
    ("interval", "text"),
    [
        ((0.0948, 0.09, 0.1), "rms.position +9.48 % [9, 10]"),
        ((-0.22, -0.225, -0.215), "rms.position −22 % [−22.5, −21.5]"),
        ((0.0, -0.01, 0.01), "rms.position 0 % [−1, 1]"),
    ],
)
def test_a_change_has_its_sign(interval, text):
    assert metric_text(metric("rms.position", *interval)) == text
