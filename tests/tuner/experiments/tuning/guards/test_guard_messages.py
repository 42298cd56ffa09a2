"""Guards on made-up results: what they must say, and when they must be silent."""

from types import SimpleNamespace

import numpy as np
import pytest

from objectives.metrics import METRICS
from tests.tuner.conftest import QUICKSTART
from tuner.api.studies import make_study
from tuner.documents.comparison_document import BoundRow
from tuner.documents.parts import Estimate
from tuner.documents.summary import ComparedRow
from tuner.experiments.tuning.guards import AFTER, BEFORE, GUARDS, warnings_before_run
from tuner.experiments.tuning.guards.after import (
    constant_objectives,
    correlated_objectives,
    duplicate_knees,
    gains_on_bounds,
    idle_candidates,
    lenient_flights,
    lost_flights,
    seldom_reached,
    still_rising,
    worse_unjudged,
)
from tuner.search.names import CONVERGED, GENERATIONS
from tuner.study.build import load_study
from tuner.study.kinds import load_gains_study

LABELS = ["error", "travel"]
NEVER = [[], []]
RNG = np.random.default_rng


def test_a_constant_objective_is_named():
    values = np.stack([RNG(1).random(20), np.full(20, 3.0)], axis=1)
    (said,) = constant_objectives(LABELS, values, NEVER)
    assert said.startswith("travel is the same for all 20 candidates flown")
    assert "no gain that is searched moves it" in said
    assert constant_objectives(LABELS, np.zeros((5, 2)), NEVER)[0].startswith("error")
    assert constant_objectives(LABELS, RNG(2).random((20, 2)), NEVER) == []
    assert constant_objectives(LABELS, values[:1], NEVER) == []
    # A tiny but real spread is not constant.
    assert constant_objectives(["error"], 1.0 + 1e-6 * RNG(3).random((9, 1)), [[]]) == []


@pytest.mark.parametrize(("value", "never"), [(9.0, True), (8.5, True), (8.0, True), (9.1, False), (0.0, False)])
def test_a_time_that_is_what_is_left_of_the_flight_is_not_the_fault_of_the_gains(value, never):
    """Settling after a step at 1 s in flights of 9 and 10 s: what never settles counts 8 and 9 s, and a mean of them between."""
    (said,) = constant_objectives(["settling"], np.full((7, 1), value), [[8.0, 9.0]])
    assert ("no flight comes to what it waits for" in said) is never
    assert ("no gain that is searched moves it" in said) is not never


def test_times_of_never_are_those_that_flights_without_an_event_are_scored_by():
    """By the metrics themselves: meters of a flight that was outside its band to the end."""
    objective = {"metric": "settling.position", "risk": "mean"}
    study = load_study(QUICKSTART, {"margin": [], "objective": [objective, {"metric": "travel"}]})
    spec, timing = study.scenarios[0].spec, study.system.timing
    (never, nothing) = study.censored_times()
    target = spec.targets(timing).x
    context = SimpleNamespace(duration=spec.duration, h=timing.control_period)
    view = SimpleNamespace(meter=SimpleNamespace(last_outside=spec.duration), target=target, context=context)
    metric = METRICS["settling"]
    assert metric.censored is not None and metric.censored(view)
    assert never == [pytest.approx(metric.value(view))] and target.time > 0.0
    assert nothing == []


def test_lenient_flights_of_a_search_are_named_with_their_ratio():
    search, held_out = np.array([[1.0, 2.0], [2.0, 0.0], [4.0, 1.0]]), np.array([[1.5, 2.0], [2.8, 9.0], [5.2, 1.1]])
    (text,) = lenient_flights(["itae", "travel"], search, held_out, [8, 4])
    assert "itae is 1.40 times as large" in text and "on the 12 of the search" in text
    assert "`tuner resume` with --search-flights 16" in text
    (text,) = lenient_flights(["itae", "travel"], search, held_out, [8, 4], resumable=False)
    assert "to 16 and run again" in text
    assert lenient_flights(["itae"], search[:0, :1], held_out[:0, :1], [8]) == []


@pytest.mark.parametrize(
    ("stop", "most", "warns"), [(CONVERGED, 16, False), (CONVERGED, 15, True), (GENERATIONS, 15, True)]
)
def test_a_search_that_converged_behind_its_back_off_is_not_said_to_rise(stop, most, warns):
    done = [SimpleNamespace(hypervolume=0.01 * n, flights=100 * n) for n in range(1, 16)]
    study = SimpleNamespace(search=SimpleNamespace(stop=stop, generations=most), is_resumable=True)
    said = GUARDS["still_rising"].message(SimpleNamespace(study=study, generations=done))
    assert bool(said) is warns


def test_a_search_that_still_gains_is_told_with_a_budget():
    # 0.5 (1 - 1 / n): the last quarter of 16 generations brings 2.2 %, that of 17 generations 1.9 %.
    volumes = [0.5 - 0.5 / n for n in range(1, 17)]
    (said,) = still_rising(volumes, [100 * n for n in range(1, 17)])
    assert (
        "2 % of the hypervolume came in the last 4 of 16 gen" in said and "about 17 generations (1,700 flights)" in said
    )
    assert "--budget 17" in said
    (said,) = still_rising(volumes, [100 * n for n in range(1, 17)], resumable=False)
    assert "resume" not in said and "search.generations = 17 and another --out" in said
    # A line has no end.
    (said,) = still_rising([0.01 * n for n in range(1, 9)], [100 * n for n in range(1, 9)])
    assert (
        "25 % of the hypervolume came in the last 2 of 8" in said
        and "cannot be estimated" in said
        and "--budget 16" in said
    )
    for resting in ([0.5, 0.7, 0.795, 0.8], [0.0] * 8, [0.7], [0.0, 0.0]):
        assert still_rising(resting, [1] * len(resting)) == []
    # The last of two generations is half of them, of which twice as much is little.
    assert still_rising([0.4, 0.415], [8, 16]) == [] and "5 %" in still_rising([0.4, 0.42], [8, 16])[0]
    assert still_rising([0.0, 0.4], [8, 16])[0].count("100 % of the hypervolume came in the last 1 of 2")


def test_objectives_that_rank_alike_are_named_whatever_the_shape():
    error = RNG(4).random(30)
    assert (
        "error and travel rank all 30" in correlated_objectives(LABELS, np.stack([error, np.exp(5 * error)], axis=1))[0]
    )
    # The opposite order is a trade-off, independence too; a constant has no ranks; few candidates may agree by chance.
    for other in (-error, RNG(5).random(30), np.ones(30)):
        assert correlated_objectives(LABELS, np.stack([error, other], axis=1)) == []
    assert correlated_objectives(LABELS, np.stack([error, error], axis=1)[:9]) == []


@pytest.mark.parametrize(
    ("word", "alike"),
    [("not distinguishable", True), ("no practical difference", True), ("better", False), ("worse", False)],
)
def test_a_point_that_is_neither_better_nor_worse_is_a_duplicate(word, alike):
    said = duplicate_knees(["default", "p1", "p2"], 1, {1: ["no practical difference"], 2: [word]})
    assert bool(said) is alike
    assert not said or ("(p1) are neither better nor worse than p2" in said[0] and "raise held_out" in said[0])


def test_one_objective_that_differs_is_enough_and_the_default_is_not_asked():
    assert duplicate_knees(["default", "p1", "p2"], 1, {2: ["not distinguishable", "worse"]}) == []
    assert duplicate_knees(["default", "p1", "p2"], 1, {1: ["no practical difference"]}) == []


def test_only_a_recommended_gain_on_an_end_that_can_be_moved_is_told():
    def on(recommended, natural, share=0.5):
        return BoundRow(
            variable="tilt.k2",
            end="high",
            bound=30.0,
            value=29.9,
            recommended=recommended,
            share=share,
            natural=natural,
        )

    assert gains_on_bounds([on(True, True), on(False, False)]) == []
    (said,) = gains_on_bounds([on(True, False)])
    assert "tilt.k2 = 29.9 is at the high end of its range, 30, as in 50 % of the front. Widen" in said
    (alone,) = gains_on_bounds([on(True, False, share=0.0)])
    assert "tilt.k2 = 29.9 is at the high end of its range, 30. Widen" in alone


def test_a_recommended_point_that_loses_flights_is_told_unless_the_study_limits_that():
    (said,) = lost_flights(1, 32, limited=False)
    assert "failed 1 of 32 confirmation flights" in said and 'metric = "failure", max = 0.0' in said
    assert lost_flights(0, 32, limited=False) == lost_flights(3, 32, limited=True) == []


def test_idle_candidates_are_counted_where_they_are_most():
    assert idle_candidates(17, 35) == [] == idle_candidates(0, 1)
    assert idle_candidates(18, 35) == [
        "18 of 35 candidates satisfied every limit except tracking and count as infeasible."
    ]


def test_the_registry_knows_when_each_speaks():
    assert {guard.when for guard in GUARDS.values()} == {BEFORE, AFTER}
    assert {
        "few_scenarios",
        "unprovable_shares",
        "default_elsewhere",
        "rates_without_damping",
        "leading_yaw",
        "mission_floor",
        "unjudged",
        "signals_after_end",
        "constant_objective",
        "correlated_objectives",
        "duplicate_knee",
        "lenient_flights",
        "lost_flights",
        "on_bound",
        "still_rising",
        "seldom_reached",
        "unlimited_margins",
        "unsampled_modes",
        "worse_unjudged",
        "wrong_units",
    } == {*GUARDS}
    assert all(guard.what and not guard.what.endswith(".") for guard in GUARDS.values())


def test_too_few_scenarios_for_the_level_are_foreseen_from_the_study_alone():
    # CVaR 0.8 asks for eight in a tail of a fifth: 40.
    few = load_study(
        QUICKSTART,
        {"margin": [], "search.algorithm": "nsga2", "scenario.0.search": 39, "scenario.0.held_out": 40},
    )
    (said,) = warnings_before_run(few)
    assert "rests on 39 search scenarios; 40 would put 8 into its tail" in said
    assert warnings_before_run(load_study(QUICKSTART, {"margin": [], "scenario.0.search": 40})) == []


@pytest.mark.parametrize(
    ("signal", "said"),
    [
        ({"kind": "step", "time": 2.0}, "steps at 2 s, after the end at 1 s"),
        ({"kind": "ramp", "time": 1.0, "until": 2.0}, "begins at 1 s, after the end at 1 s"),
        ({"kind": "step", "time": 0.9}, None),
        ({"kind": "sine"}, None),
    ],
)
@pytest.mark.parametrize("key", ["reference.angle", "disturbance.torque"])
def test_signals_that_begin_after_the_end_are_named(key, signal, said):
    changes = {"scenario.0.duration": 1.0, f"scenario.0.{key}": signal, "constraint.0.metric": "peak.angle"}
    study = load_gains_study(QUICKSTART.parent / "dc_motor.toml", "test", changes)
    name = study.scenarios[0].spec.name
    texts = [text for text in warnings_before_run(study) if "after the end" in text]
    assert [text.startswith(f'Scenario "{name}": {key} {said}') for text in texts] == [True] * (said is not None)


@pytest.mark.parametrize(
    ("period", "said"), [(0.2, "swings at 10 Hz, above half the sampling rate, 2.5 Hz"), (0.04, "")]
)
def test_a_mode_above_half_the_sampling_rate_is_named(period, said):
    """A mode of 10 Hz: w^2/(s^2 + 0.02 w s + w^2)."""
    w = 20.0 * np.pi
    study = make_study(
        {
            "title": "Mode", "seed": 1,
            "plant": {
                "transfer_function": {"numerator": [w**2], "denominator": [1.0, 0.02 * w, w**2]}, "control_period": period,
            },
            "channel": [{"name": "y", "law": "pid_parallel", "output": "y", "to": "u", "lost_beyond": 9.0}],
            "gains": {"y.kp": 0.0001, "y.ki": {"low": 0.1, "high": 1.0}, "y.kd": 0.0, "y.t_f": 0.0},
            "scenario": [{"name": "rest", "duration": 1.0, "search": 16, "held_out": 64}],
            "objective": [{"metric": "rms.y", "risk": "mean"}],
            "mission": {"off": ["rms.y"]},
        }
    )  # fmt: skip
    texts = [text for text in warnings_before_run(study) if "swings" in text]
    assert len(texts) == bool(said) and all(said in text and "up to 0.05 s" in text for text in texts)


def test_a_share_that_the_flights_cannot_show_is_told_with_the_flights_that_it_takes():
    limit = {"margin": [], "constraint": [{"metric": "failure", "max": 0.01}]}
    (said,) = warnings_before_run(load_study(QUICKSTART, {**limit, "scenario.0.held_out": 64}))
    assert (
        "mean(failure) at most 0.01 cannot be shown by 64 held-out flights" in said and "It takes 368 flights" in said
    )
    for enough in (
        {"scenario.0.held_out": 368},
        {"confidence": 0.0},
        {"constraint": [{"metric": "failure", "max": 0.0}]},
    ):
        assert warnings_before_run(load_study(QUICKSTART, {**limit, **enough})) == []


def test_a_limit_in_another_unit_is_named_with_what_was_meant():
    def said(metric, most):
        limit = {"metric": metric, "max": most}
        study = load_study(QUICKSTART, {"constraint": [limit]})
        return GUARDS["wrong_units"].message(study)

    (degrees,) = said("peak.tilt", 10.0)
    assert "10 deg is 0.1745" in degrees
    (per_cent,) = said("overshoot.position", 0.15)
    assert "a share of 0.15 is 15" in per_cent
    for metric, most in (
        ("peak.tilt", 0.17),
        ("saturation", 0.02),
        ("overshoot.position", 15.0),
        ("rms.position", 10.0),
    ):
        assert said(metric, most) == []
    margin = {"quantity": "phase_margin", "min": 0.61}
    (limit,) = GUARDS["wrong_units"].message(load_study(QUICKSTART, {"margin": [margin]}))
    assert limit.endswith("at least 0.61 deg: the limit is in deg; 0.61 rad is 35.")
    assert GUARDS["wrong_units"].message(load_study(QUICKSTART, {"margin": [margin | {"min": 35.0}]})) == []
    # A limit of 0 is none in another unit.
    assert said("overshoot.position", 0.0) == [] and said("failure", 0.0) == []


def a_row(default, tuned, half, scenario: str | None = "gusts"):
    return ComparedRow(
        label="quantile50(rms.tilt)",
        metric="rms.tilt",
        definition="error",
        risk="quantile",
        scenario=scenario,
        unit="rad",
        kind="constraint",
        limit=0.5,
        default=Estimate(default, default, default),
        tuned=Estimate(tuned, tuned, tuned),
        difference=Estimate(tuned - default, tuned - default - half, tuned - default + half),
        verdict="satisfied",
        automatic="mission.held",
    )


def test_a_quantity_that_nothing_judges_is_named_where_it_became_much_worse():
    (said,) = worse_unjudged([a_row(0.01, 0.02, 0.001)])
    assert "rises from 0.573 to 1.15 °" in said and '[[objective]] metric = "rms.tilt", scenario = "gusts"' in said
    (said,) = worse_unjudged([a_row(0.01, 0.02, 0.001, None)])
    assert said.endswith('metric = "rms.tilt".')
    # By less than half, not surely, or better.
    for tuned, half in ((0.0149, 0.001), (0.02, 0.011), (0.005, 0.001)):
        assert worse_unjudged([a_row(0.01, tuned, half)]) == []
    assert worse_unjudged([]) == []


def test_usual_margins_count_where_a_study_limits_none():
    def said(changes, gains=None, tuned=1):
        study = load_study(QUICKSTART, changes)
        row = study.default_row if gains is None else gains
        return GUARDS["unlimited_margins"].message(
            SimpleNamespace(study=study, feasible=True, tuned=tuned, gains=lambda _: row)
        )

    free = load_study(QUICKSTART, {"margin": []})
    model = free.margin_model()
    margins = model.evaluate(free.default_row[None])
    looped = [margins.channels.index(channel) for block in model.blocks for channel in block]
    phase, peak = (np.asarray(entry.value)[0, looped] for entry in (margins.phase, margins.sensitivity))
    (text,) = said({"margin": []})
    assert f"phase margin {np.rad2deg(phase.min()):.3g}" in text.replace(" (usual", "") or phase.min() >= np.deg2rad(
        35.0
    )
    assert ("Ms" in text.split("usual limits:")[1].split("Add")[0]) is bool(peak.max() > 2.0)
    assert '[[margin]] quantity = "ms", max = 2' in text
    # A study that limits a margin chose its own, and a default that stays was not found by the search.
    assert said({}) == [] and said({"margin": []}, tuned=0) == []


def test_a_time_that_most_flights_do_not_come_to_is_named():
    labels, never = ["settling", "travel"], [[19.0], []]
    (said,) = seldom_reached(labels, [18.7, 3.0], never)
    assert (
        said.startswith("settling is 18.7 s, and 19 s is the value of a flight") and "error instead of a time" in said
    )
    assert seldom_reached(labels, [17.0, 3.0], never) == []
    assert seldom_reached(labels, [None, 3.0], never) == []
    # Of two scenarios of 10 and 20 s left, 14 s is more than nine tenths of their mean.
    assert seldom_reached(["settling"], [14.0], [[10.0, 20.0]]) and not seldom_reached(
        ["settling"], [13.0], [[10.0, 20.0]]
    )


TWO_CHANNELS = """
title = "Two tanks"
seed = 1
[plant]
state_space = { A = [[-1.0, 0.0], [0.0, -1.0]], B = [[1.0, 0.0], [0.0, 1.0]], C = [[1.0, 0.0], [0.0, 1.0]] }
inputs = ["left_valve", "right_valve"]
outputs = ["left", "right"]
control_period = 0.1
[[channel]]
name = "left"
law = "pid"
output = "left"
to = "left_valve"
lost_beyond = 10.0
[[channel]]
name = "right"
law = "pid"
output = "right"
to = "right_valve"
lost_beyond = 10.0
[gains]
"left.kp" = { low = 0.1, high = 2.0, default = 1.0 }
"left.ki" = 0.5
"left.kd" = 0.0
"left.t_f" = 0.2
"right.kp" = 1.0
"right.ki" = 0.5
"right.kd" = 0.0
"right.t_f" = 0.2
[[scenario]]
name = "step"
duration = 10.0
search = 4
held_out = 8
reference.left = { kind = "step", size = 1.0, time = 3.0 }
[[objective]]
metric = "settling.left"
"""


@pytest.mark.slow
def test_the_time_left_is_that_behind_the_step_of_the_objectives_own_channel(tmp_path):
    """The other channel rests from the start of the flight on; 7 s are left behind the step at 3 s of 10 s."""
    file = tmp_path / "tanks.toml"
    file.write_text(TWO_CHANNELS)
    assert load_gains_study(file, "run").censored_times() == [[pytest.approx(7.0)]]
