"""Outputs and inputs that no channel controls are judged by their own values."""

import copy
from math import exp, sqrt

import numpy as np
import pytest

import tuner
from objectives.own_meters import metering
from objectives.problem import FlightBatch, Problem
from plant.errors import InputError
from plant.quadrotor.scenarios import SEARCH
from tuner.study.plant_study import PlantStudy

H, GAIN, STEPS = 0.1, 3.0, 50
TABLES = {
    "title": "A room, and the heat that it loses",
    "seed": 1,
    "plant": {
        "state_space": {"A": [[-1.0]], "B": [[1.0]], "C": [[1.0], [-2.0]]},
        "inputs": ["heat"],
        "outputs": ["warmth", "loss"],
        "control_period": H,
        "lost_beyond": {"loss": 9.0},
    },
    "actuator": [{"name": "heat", "low": -10.0, "high": 10.0}],
    "channel": [{"name": "room", "law": "pid", "output": "warmth", "to": "heat", "lost_beyond": 5.0}],
    "gains": {"room.kp": {"low": 1.0, "high": 9.0, "default": GAIN}, "room.ki": 0.0, "room.kd": 0.0, "room.t_f": 1.0},
    "scenario": [{"name": "step", "duration": STEPS * H, "reference": {"room": {"kind": "step", "size": 1.0}}}],
    "objective": [{"metric": "rms.loss"}, {"metric": "rms.heat"}],
    "constraint": [
        {"metric": "peak.heat", "max": 6.0},
        {"metric": "iae.loss", "max": 60.0},
        {"metric": "failure", "max": 0.5},
    ],
}


def room(**changes):
    tables = copy.deepcopy(TABLES)
    for key, value in changes.items():
        tables[key] = value
    return tuner.make_study(tables, kind=PlantStudy)


def values(study, *others):
    """Return the metrics of one flight of the default, by address."""
    judged = [*study.objectives, *[each.objective for each in study.constraints], *others]
    problem = Problem(study.system, study.space, tuple(judged), (), study.seed)
    flown = problem.evaluate_gains(
        np.array([study.default_row]), (FlightBatch(study.scenarios[0].spec, SEARCH, 1),), fly_all=True
    )
    return dict(zip([each.metric.text for each in judged], flown.values[0].tolist(), strict=True))


def recurrence():
    """Return the warmth and the heat at each instant under proportional control of a lag of 1 s, held in between."""
    decay, warmth, heat = exp(-H), [0.0], list[float]()
    for _ in range(STEPS):
        heat.append(GAIN * (1.0 - warmth[-1]))
        warmth.append(decay * warmth[-1] + (1.0 - decay) * heat[-1])
    return np.array(warmth[:-1]), np.array(heat)


def test_values_are_those_of_the_sampled_loop():
    warmth, heat = recurrence()
    found = values(room())
    assert found["rms.heat"] == pytest.approx(sqrt(np.mean(heat**2)), rel=1e-4)
    assert found["peak.heat"] == pytest.approx(GAIN)
    assert found["rms.loss"] == pytest.approx(2.0 * sqrt(np.mean(warmth**2)), rel=1e-4)
    assert found["iae.loss"] == pytest.approx(2.0 * H * np.sum(warmth), rel=1e-4)


def test_a_flight_is_lost_beyond_the_limit_of_a_signal():
    assert values(room())["failure"] == 0.0
    study = room(plant={**TABLES["plant"], "lost_beyond": {"loss": 1.2}})  # it comes to 1.5
    assert values(study)["failure"] == 1.0
    assert "1.2 1 off in loss" in str(study.system.failure_causes)


def test_responses_show_a_watched_output():
    system = room().system
    assert list(system.signals) == ["room", "loss", "heat"]
    warmth, loss, heat, command = range(4)
    trace, references = np.array([[[warmth, loss, heat, command]]], dtype=float), np.array([[7.0, 0.0, 0.0]])
    actual, reference = system.responses(trace, references)
    assert actual.tolist() == [[[warmth, loss, heat]]]
    assert reference[0, 0, 0] == 7.0 and np.isnan(reference[0, 0, 1:]).all()


def test_a_study_that_judges_channels_alone_flies_the_loop_of_before():
    study = room(objective=[{"metric": "rms.room"}], constraint=[], plant={**TABLES["plant"], "lost_beyond": {}})
    assert study.system.plan.watched == ()
    assert metering(study.system, []) is study.system


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"plant": {**TABLES["plant"], "lost_beyond": {}}}, r"'rms.loss' judges loss, .* lost_beyond = \{ loss"),
        ({"actuator": []}, r"'rms.heat' judges heat, .* \[\[actuator\]\]"),
        ({"plant": {**TABLES["plant"], "lost_beyond": {"room": 1.0}}}, r"lost_beyond in its \[\[channel\]\]"),
        ({"plant": {**TABLES["plant"], "lost_beyond": {"los": 1.0}}}, "'los'.* loss"),
        ({"objective": [{"metric": "overshoot.loss"}]}, "needs a step"),
        ({"objective": [{"metric": "rms.coldness"}]}, "coldness"),
    ],
)
def test_a_signal_without_bound_or_name_is_refused(changes, said):
    with pytest.raises(InputError, match=said):
        room(**changes)
