"""A converter is judged by its coil's current and a motor by its heat, which no loop controls."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import tuner
from objectives.plant_system import PlantSystem
from tests.plant.model.plants import stepped
from tests.tuner.extensions.textbook_laws.loops import row_of
from tuner.study.plant_study import PlantStudy

HERE = Path(__file__).parent


def loaded(name):
    """A study and its plant without spread."""
    return tuner.load_study(HERE / name, {"scenario.0.spread": {}}, kind=PlantStudy)


def flown(study, **gains):
    """Outputs by name (K,) of one flight in Python, and its times."""
    system, spec = study.system, study.scenarios[0].spec
    assert isinstance(system, PlantSystem)
    rows, _ = stepped(system, row_of(system, **gains), system.sample(spec, 1, "search", [0]))
    names = [*system.plant.State._fields, *system.plant.Input._fields, *system.plant.Output._fields]
    outputs = {name: rows[:, len(names) - 1 - names[::-1].index(name)] for name in system.plant.Output._fields}
    return outputs, system.timing.control_period * np.arange(len(rows))


@pytest.mark.parametrize(
    ("name", "watched", "unit"), [("converter.toml", ("current",), "A"), ("motor_heat.toml", ("warmth",), "K")]
)
def test_a_study_of_40_lines_limits_what_no_loop_controls(name, watched, unit):
    study = loaded(name)
    assert len([line for line in (HERE / name).read_text().splitlines() if line]) <= 40
    assert study.system.watched == watched
    assert study.constraints[0].objective.metric.unit == unit


def test_a_load_step_rings_the_coil_as_its_circuit_does():
    """Hardly controlled, the coil's current follows a load step with the overshoot of the damped LC circuit."""
    outputs, t = flown(loaded("converter.toml"), kp=1e-9, ki=0.0, kd=0.0, t_f=0.0)
    inductance, winding, capacitance, resistance = 47e-6, 0.05, 220e-6, 5.0
    # Its poles are the roots of s^2 + (1/RC + r/L) s + (1 + r/R)/LC; the load's share of the coil is 1/(1 + r/R) in the end.
    damping = 0.5 * (1.0 / (resistance * capacitance) + winding / inductance)
    square = (1.0 + winding / resistance) / (inductance * capacitance)
    swing = np.sqrt(square - damping * damping)
    share = 1.0 / (1.0 + winding / resistance)
    later = np.maximum(t - 2e-4, 0.0)
    # From the load to the coil there is no zero, so the answer is that of a plain second order.
    rung = share * (1.0 - np.exp(-damping * later) * (np.cos(swing * later) + damping / swing * np.sin(swing * later)))
    assert outputs["current"] == pytest.approx(1.0 + rung, abs=2e-3)
    assert 2.5 < outputs["current"].max() < 2.8


def test_the_winding_warms_by_the_energy_of_its_current():
    """The same drive in continuous time, by SciPy."""
    outputs, t = flown(loaded("motor_heat.toml"), kp=1.0, ki=0.0, kd=0.0, t_f=0.0)

    def rate(_, x):
        current = (1.0 - x[0] - 0.0274 * x[1]) / 4.0
        return x[1], (0.0274 * current - 3.5077e-6 * x[1]) / 3.2284e-6, (4.0 * current**2 - x[2] / 15.0) / 2.0

    right = solve_ivp(rate, (0.0, t[-1]), (0.0, 0.0, 0.0), t_eval=t, rtol=1e-9, atol=1e-12).y
    assert outputs["angle"] == pytest.approx(right[0], abs=0.03)
    assert outputs["warmth"][-1] == pytest.approx(right[2][-1], rel=0.02) and right[2][-1] > 1e-3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "gain", "metric"), [("converter.toml", "ki", "peak.current"), ("motor_heat.toml", "kp", "peak.warmth")]
)
def test_a_harder_loop_costs_current_and_heat(name, gain, metric):
    study = loaded(name)
    peaks = [
        tuner.fly(tuner.default_gains(study).replace({gain: factor * value}), flights=4).table.loc[metric, "mean"]
        for value in [tuner.default_gains(study)[f"{study.system.plan.names[0]}.{gain}"]]
        for factor in (0.3, 1.0, 3.0)
    ]
    assert peaks == sorted(peaks) and peaks[-1] > 1.02 * peaks[0]
