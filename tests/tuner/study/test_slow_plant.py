"""A process loop: control periods of seconds to an hour, hours of flight, and a rest that is not 0."""

import subprocess
from functools import cache
from types import SimpleNamespace
from typing import Any

import control
import numpy as np
import pytest
from scipy.linalg import expm

import tuner
from objectives.margins.plant_margins import PlantMargins
from objectives.problem import score_flights
from plant.errors import InputError
from plant.own_code import run_own_code
from plant.records import flatten
from tests.clients import program
from tests.objectives.margins.python_control import Loop, classical
from tests.plant.model.plants import FILES, stepped
from tuner.api.studies import make_study
from tuner.exchange.c99.export import export_plant
from tuner.experiments.tuning.tables import margin_table
from tuner.gains import plant_gains_document
from tuner.store.document import json_text
from tuner.study.plant_margins import plant_margins

PERIOD, HORIZON, STEP, AT = 10.0, 7200.0, 5.0, 600.0
KP, KI = 60.0, 0.05
METRICS = ("iae", "itae", "peak", "overshoot", "rise")
QUIET: dict = {"reference": {}, "metrics": ("iae",)}


def tables(
    period: float = PERIOD, plant_step: float | None = None, metrics: tuple[str, ...] = METRICS, **scenario: object
) -> dict:
    return {
        "title": "A kiln",
        "seed": 1,
        "plant": {"control_period": period, **({} if plant_step is None else {"plant_step": plant_step})},
        "actuator": [{"name": "power", "low": 0.0, "high": 1e4}],
        "channel": [{"name": "heat", "law": "pid", "output": "chamber", "to": "power", "lost_beyond": 100.0}],
        "gains": {
            "heat.kp": {"low": 1.0, "high": 500.0, "default": KP},
            "heat.ki": KI,
            "heat.kd": 0.0,
            "heat.t_f": 0.0,
        },
        "scenario": [
            {
                "name": "step",
                "duration": HORIZON,
                "search": 4,
                "held_out": 8,
                "reference": {"heat": {"kind": "step", "size": STEP, "time": AT}},
                **scenario,
            }
        ],
        "objective": [{"metric": f"{metric}.heat"} for metric in metrics],
    }


def study_of(**changes):
    return make_study(tables(**changes), "kiln", plant=run_own_code(FILES["kiln"]).names)


@cache
def matrices(period):
    """The kiln over a period from its rest, by the exponential of its matrix."""
    a = np.array([[-20.0 / 2000.0, 20.0 / 2000.0], [20.0 / 4e4, -28.0 / 4e4]])
    whole = expm(period * np.block([[a, np.array([[1.0 / 2000.0], [0.0]])], [np.zeros((1, 3))]]))
    return whole[:2, :2], whole[:2, 2]


def temperatures(period=PERIOD):
    """Return how far the chamber is from where it rests at every period, under a PI controller, and what is asked."""
    a, b = matrices(period)
    x, integral, seen, asked = np.zeros(2), 0.0, [], []
    for k in range(round(HORIZON / period)):
        goal = STEP if k * period >= AT else 0.0
        seen.append(x[1])
        asked.append(goal)
        error = goal - x[1]
        x = a @ x + b * (KP * error + integral)
        integral += period * KI * error
    return np.array(seen), np.array(asked)


def flown(study, lanes=1):
    """Fly the default in Python: the temperatures shown, of one lane after the other, and the scores of the first."""
    system, spec = study.system, study.scenarios[0].spec
    drawn = system.sample(spec, study.seed, "search", range(lanes))
    flights = [stepped(system, study.default_row, drawn, lane) for lane in range(lanes)]
    last = flights[0][1]
    results = np.array([*flatten(last.meters), last.status, last.end_time])
    scores, failed = score_flights(system, [each.metric for each in study.objectives], results, spec, drawn.targets)
    assert not failed
    return np.array([bodies[:, -1] for bodies, _ in flights]), {
        each.metric.metric.name: score for each, score in zip(study.objectives, scores, strict=True)
    }


def test_a_step_counts_from_the_rest_and_two_hours_of_it_are_those_of_the_exponential():
    seen, asked = temperatures()
    error, times = asked - seen, PERIOD * np.arange(len(seen))
    climbing = slice(0, int(seen.argmax()) + 1)
    at_10, at_90 = np.interp([0.1 * STEP, 0.9 * STEP], seen[climbing], times[climbing])
    shown, found = flown(study_of())
    np.testing.assert_allclose(shown[0], 600.0 + seen, atol=1e-5 * STEP)
    assert found["iae"] == pytest.approx(PERIOD * np.abs(error).sum(), rel=1e-5)
    assert found["itae"] == pytest.approx(2.0 * PERIOD * (times * np.abs(error)).sum() / HORIZON**2, rel=1e-5)
    assert found["peak"] == pytest.approx(STEP, rel=1e-9)
    assert found["overshoot"] == pytest.approx(100.0 * (seen.max() / STEP - 1.0), rel=1e-4)
    assert found["rise"] == pytest.approx(at_90 - at_10, rel=1e-4)


def test_without_a_reference_it_stays_where_it_rests():
    shown, _ = flown(study_of(**QUIET))
    assert np.abs(shown - 600.0).max() < 1e-9


def test_a_set_point_is_where_the_nominal_plant_rests_whatever_the_drawn_one_does():
    """A controller is told a temperature; a kiln that was left at another one is brought there."""
    shown, _ = flown(study_of(**QUIET, spread={"hold": 0.02}), lanes=4)
    starts, ends = shown[:, 0] - 600.0, shown[:, -1] - 600.0
    assert np.ptp(starts) > 1.0
    assert np.abs(ends).max() < 0.01 * np.abs(starts).max()


def test_its_margins_are_those_of_python_control():
    a, b = matrices(PERIOD)
    plant = control.ss(a, b[:, None], [[0.0, 1.0]], 0.0, PERIOD)
    z: Any = control.tf([1.0, 0.0], [1.0], PERIOD)
    judge = Loop(plant * (KP + KI * PERIOD / (z - 1.0)), PERIOD, np.geomspace(1e-7, np.pi / PERIOD, 3000))
    study = study_of()
    margins = PlantMargins(study.system, study.default_row, 2.0 * study.default_row).evaluate(study.default_row[None])
    wanted = {**classical(judge), "sensitivity": 1.0 / judge.least(lambda x: np.abs(1.0 + x))}
    assert margins.stable[0, 0]
    assert {what: getattr(margins, what).value[0, 0] for what in wanted} == pytest.approx(wanted, rel=1e-4)


def test_an_hour_is_a_period_where_the_plant_step_is_short_enough():
    """The fastest mode of the kiln has a time constant of 98 s: a Runge-Kutta step of an hour would let it grow."""
    slow = {"period": 3600.0, "duration": 36000.0, **QUIET}
    with pytest.raises(InputError, match="time constant of 9[0-9.]* s") as caught:
        study_of(**slow, plant_step=3600.0)
    assert caught.value.key == "plant.plant_step"
    advised = float(str(caught.value).split("plant_step = ")[1])
    assert study_of(**slow).system.timing.plant_step == pytest.approx(advised)
    for step in (None, advised):
        assert np.abs(flown(study_of(**slow, plant_step=step))[0] - 600.0).max() < 1e-9


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a_plant_step_is_refused_where_runge_and_kutta_diverge(share):
    """On a decaying mode alone the method diverges at 2.7853 time constants: the root of 1 + z/2 + z^2/6 + z^3/24."""
    fastest = np.abs(np.log(np.linalg.eigvals(matrices(1.0)[0]))).max()
    step = share * 2.785293563405282 / fastest
    slow = {"period": step, "plant_step": step, "duration": 40.0 * step, **QUIET}
    if share > 1.0:
        with pytest.raises(InputError, match="would grow"):
            study_of(**slow)
    else:
        assert study_of(**slow).system.timing.plant_step == step


def test_periods_beyond_an_hour_are_refused_in_a_line():
    with pytest.raises(InputError, match=r"given 3601 s; allowed: 1e-05 s to 3600 s") as caught:
        study_of(period=3601.0)
    assert caught.value.key == "plant.control_period" and "\n" not in str(caught.value)


def test_its_controller_in_c_is_the_one_that_flew(tmp_path):
    study = study_of()
    export_plant(study.system, study.default_row.tolist(), tmp_path, real="double")
    made = subprocess.run([program("make")], cwd=tmp_path, capture_output=True, text=True)
    assert made.returncode == 0, made.stderr[-2000:]


def test_the_curves_of_the_report_show_where_the_loop_crosses_over():
    study = study_of(metrics=("iae",))
    outcome: Any = SimpleNamespace(study=study, finalist_rows=study.default_row[None], names=["default"])
    table = margin_table(outcome)
    assert table is not None
    (frequency,), (real,), (imag,) = (table[name] for name in ("frequency", "real", "imag"))
    gain = np.abs(real + 1j * imag)
    # The report once began at 0.05 rad/s: this loop has crossed over long before.
    assert table["crossover"][0] < 0.05
    assert frequency[0] < 0.2 * table["crossover"][0] and gain[0] > 3.0 and gain[-1] < 0.3


@pytest.mark.parametrize("period", [0.5, 2400.0])
def test_a_grid_begins_below_the_crossover_however_fast_the_loop_is_sampled(period):
    study = study_of(period=period, plant_step=min(period, 60.0), duration=36000.0, **QUIET)
    model = plant_margins(study.system, study.space)
    margins = model.evaluate(study.default_row[None])
    grid, crossover = model.figure_frequencies(margins, 120), margins.crossover.value[0, 0]
    assert len(grid) == 120 and grid[-1] == pytest.approx(np.pi / period)
    assert grid[0] < 0.2 * crossover if crossover > 0.0 else grid[0] == pytest.approx(1e-4 * np.pi / period)


@pytest.mark.slow
def test_a_slow_plant_is_flown_without_the_noise_that_its_rate_does_not_show(tmp_path):
    study = study_of(metrics=("iae",))
    file = tmp_path / "gains.json"
    document = plant_gains_document(study.system, study.default_row, study.code_digest)
    file.write_text(json_text(document), encoding="utf-8")
    table = tuner.fly(str(file), study=study, flights=2).table
    assert "noise" not in table.index and "travel" in table.index
