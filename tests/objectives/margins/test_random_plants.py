"""Forty plants drawn at random: margins against loops that SciPy samples, flights against steps 32 times as short."""

from dataclasses import asdict, replace

import numpy as np
import pytest

from objectives.margins.plant_margins import PlantMargins
from objectives.problem import score_flights
from plant.own_code import run_own_code
from plant.records import flatten
from tests.objectives.margins.python_control import Loop, classical
from tests.objectives.margins.random_plants import KINDS, Draw, drawn, grid
from tests.plant.model.plants import FILES, stepped
from tuner.api.studies import make_study

PERIODS, METRICS = 200, ("iae.place", "itae.place", "rms.place", "peak.place", "overshoot.place", "travel", "effort")
# One of each kind in every run: the default step divides their periods by 2 to 5, so they fly fast.
QUICK = (10, 19, 21)
NUMBERS = [pytest.param(i, marks=[] if i in QUICK else pytest.mark.slow) for i in range(40)]


def study_of(draw):
    """A study of a drawn plant: a step, a push that wanders and a noisy sensor, at the default plant step."""
    channels = [
        {"name": "place", "law": "pid", "output": "place", "to": "force", "every": draw.every, "lost_beyond": 1e6}
    ]
    if draw.kind == "cascade":
        channels[0]["to"] = "speed"
        channels += [{"name": "speed", "law": "pid", "output": "speed", "to": "force", "lost_beyond": 1e6}]
    names = [f"{each['name']}.{gain}" for each in channels for gain in ("kp", "ki", "kd", "t_f")]
    step = draw.every * draw.h
    tables = {
        "title": "Drawn",
        "seed": 7,
        "plant": {"control_period": draw.h, "parameters": draw.parameters},
        "channel": channels,
        "actuator": [
            {"name": "force", "low": -1e6, "high": 1e6, "delay": draw.delay * draw.h, "lag": draw.lag, "scale": 1.0}
        ],
        "gains": dict(zip(names, draw.gains, strict=True)),
        "scenario": [
            {
                "name": "step",
                "duration": PERIODS * draw.h,
                "search": 1,
                "held_out": 2,
                "sensors": {"place": {"rms": 1e-3}},
                "reference": {"place": {"kind": "step", "size": 1.0}},
                "disturbance": {"push": {"kind": "coloured", "rms": 0.01 / step**2, "correlation_time": 5.0 * step}},
            }
        ],
        "objective": [{"metric": metric} for metric in METRICS],
    }
    return make_study(tables, "drawn", plant=run_own_code(FILES["modal"]).names)


def test_forty_plants_are_of_every_sort():
    draws = [drawn(i) for i in range(40)]
    modes = np.concatenate([draw.resonances * [draw.h / np.pi, 1.0] for draw in draws])
    assert (
        modes[:, 0].max() > 0.75 and modes[:, 0].max() <= 0.8 and modes[:, 1].min() < 0.005 and modes[:, 1].max() > 0.6
    )
    assert {draw.kind for draw in draws} == set(KINDS) and {draw.delay for draw in draws} == {0, 1, 2, 3}
    assert sum(min(draw.parameters["stiffness"], draw.parameters["friction"]) < 0.0 for draw in draws) >= 10
    assert sum(draw.lag > 0.0 for draw in draws) >= 10


@pytest.mark.parametrize(("kd", "largest"), [(4.0, 1.84), (8.0, 2.67), (12.0, 4.09), (20.0, np.inf)])
def test_the_sway_of_two_masses_is_not_damped_by_the_integration(kd, largest):
    """Pushed on one mass and measured on the other: 50 rad/s, damped by 0.01, at 40 ms, 2 rad a period."""
    parameters = {**asdict(drawn(0))["parameters"], "stiffness": 0.0, "friction": 0.0, "second_share": 0.0}
    parameters |= {"first_frequency": 50.0, "first_damping": 0.01, "first_share": -1.0}
    sway = Draw(KINDS[0], parameters, 0.04, 0, 0.0, 1, (4.0, 0.0, kd, 0.0))
    gains = np.array(sway.gains)
    found = PlantMargins(study_of(sway).system, gains, gains).evaluate(gains[None])
    assert found.stable[0, 0] == np.isfinite(largest)
    assert found.sensitivity.value[0, 0] == pytest.approx(largest, abs=0.01)


@pytest.mark.parametrize("number", NUMBERS)
def test_margins_are_those_of_the_loop_that_scipy_samples(number):
    draw, gains = drawn(number), np.array(drawn(number).gains)
    system = study_of(draw).system
    margins = PlantMargins(system, gains, gains).evaluate(gains[None])
    loop, step = draw.outer_loop()
    judge = Loop(loop, step, grid(draw, step))
    wanted = {**classical(judge), "sensitivity": 1.0 / judge.least(lambda x: np.abs(1.0 + x))}
    assert margins.stable[0, 0]
    found = {what: getattr(margins, what).value[0, 0] for what in wanted}
    assert found == pytest.approx(wanted, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("number", NUMBERS)
def test_metrics_at_the_default_step_are_those_of_a_step_32_times_as_short(number):
    study = study_of(drawn(number))
    timing = study.system.timing
    usual, short = (scores(study, timing._replace(plant_step=timing.plant_step / n)) for n in (1, 32))
    assert usual == pytest.approx(short, rel=1e-3)


def scores(study, timing):
    """The metrics of one flight of a study at a timing."""
    system, spec = replace(study.system, timing=timing), study.scenarios[0].spec
    inputs = system.sample(spec, study.seed, "search", range(1))
    last = stepped(system, study.default_row, inputs)[1]
    results = np.array([*flatten(last.meters), last.status, last.end_time])
    found, failed = score_flights(system, [each.metric for each in study.objectives], results, spec, inputs.targets)
    assert not failed
    return dict(zip(METRICS, found, strict=True))
