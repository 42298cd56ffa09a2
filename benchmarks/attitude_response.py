"""Attitude loops of our Crazyflies beside those of real ones, in one form: `python -m benchmarks.attitude_response`.

The package drone-models 0.1.0 (utiasDSL, MIT) fits how the roll and pitch of real Crazyflies follow their commands as

    angle'' = a angle + b angle' + c command,        a [1/s2], b [1/s], c [1/s2],

so with a natural frequency sqrt(-a), a damping ratio -b / (2 sqrt(-a)) and a gain at rest -c / a. Here the loops of
`studies/crazyflie_firmware.toml` fly a figure eight in the study's draught with the firmware's default parameters, on each of
our Crazyflies and on one with the mass, arm, inertia and thrust that the package gives for a real one and the rotor lag that
`tuner identify` finds in the log of another (docs/identify.md). The same three numbers are fitted to each flight by output
error: the angle is predicted from the commands alone.
"""

import math
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import cont2discrete, lfilter, ss2tf

import tuner
from objectives.system import System
from plant.backends.array import rebinder
from plant.quadrotor.attitude import euler_angles
from plant.quadrotor.gains import default_row
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.scenarios import SEARCH, ScenarioSpec
from plant.records import paths
from plant.vectors import Quaternion, Rotors, Vec3
from tuner.study.study import Study

STUDY = Path(__file__).parents[1] / "studies" / "crazyflie_firmware.toml"
AIRFRAMES = ("crazyflie-pybullet", "crazyflie-rotors")
SCENARIO = {
    "duration": 20.0,
    "spread": {},
    "sensors": dict.fromkeys(("position", "velocity", "attitude", "rate"), 0.0),
    "reference": {"kind": "figure_eight", "size": 1.0, "period": 2.5},
}
ROWS = ("control.tilt.roll", "body.attitude.w", "body.attitude.x", "body.attitude.y", "body.attitude.z")
REAL = {
    "cf2x_L250": (-245.67, -17.32, 196.18),
    "cf2x_P250": (-319.14, -20.85, 263.30),
    "cf2x_T350": (-267.14, -19.48, 200.90),
    "cf21B_500": (-188.991, -12.7803, 138.0834),
}
"""drone_models/so_rpy/params.toml: rpy_coef, rpy_rates_coef, cmd_rpy_coef of roll and pitch."""


def study(airframe: str) -> Study:
    """Return the study with a figure eight, perfect sensors and the nominal vehicle on an airframe."""
    tables: dict[str, Any] = tomllib.loads(STUDY.read_text(encoding="utf-8")) | {"airframe": {"name": airframe}}
    tables["scenario"] = [tables["scenario"][0] | SCENARIO]
    return tuner.make_study(tables, airframe, STUDY.parent, kind=Study)


def as_measured(system: System) -> System:
    """Return the system with mass, arm, inertia and full thrust of cf2x_L250, and the rotor lag identified from a log."""
    arm = 0.03253
    known = system.vehicle
    vehicle = known._replace(
        mass=0.0319,
        inertia=Vec3(16.8e-6, 16.8e-6, 29.8e-6),
        lag_up=0.0525,
        lag_down=0.093,
        rotor_x=Rotors(*[math.copysign(arm, x) for x in known.rotor_x]),
        rotor_y=Rotors(*[math.copysign(arm, y) for y in known.rotor_y]),
        thrust_coefficient=0.12 / known.speed_max**2,
    )
    return replace(
        system, vehicle=vehicle, nominal=nominal(vehicle, ControlOptions(delay=True), system.timing.control_period)
    )


def flown(system: System, spec: ScenarioSpec) -> tuple[np.ndarray, np.ndarray]:
    """Return the roll commanded and flown [rad] at every control instant of one flight with default gains."""
    inputs = system.sample(spec, 2025, SEARCH, [0])
    names = paths(system.loop.Flight)
    gains = np.array(default_row(system.cascade, system.vehicle))
    trace = system.flyer(1).trace(gains, system.nominal, inputs, traced=[names.index(row) for row in ROWS])[0]
    return trace[:, 0], np.array(rebinder()(euler_angles)(Quaternion(*trace[:, 1:].T)).x)


def predicted(numbers: np.ndarray, command: np.ndarray, h: float) -> np.ndarray:
    """Return the angle that the form makes of the commands, held over the periods h [s]."""
    a, b, c = numbers
    form = (np.array([[0.0, 1.0], [a, b]]), np.array([[0.0], [c]]), np.array([[1.0, 0.0]]), np.zeros((1, 1)))
    stepped: Any = cont2discrete(form, h)
    top, bottom = ss2tf(*stepped[:4])
    return np.asarray(lfilter(top[0], bottom, command))


def fitted(command: np.ndarray, angle: np.ndarray, h: float) -> tuple[np.ndarray, float]:
    """Return a, b, c by output error, and the share of the angle's variance that they explain."""
    middle = command.mean()

    def residual(numbers: np.ndarray) -> np.ndarray:
        return predicted(numbers, command - middle, h) - (angle - angle.mean())

    found = least_squares(residual, REAL["cf2x_L250"], x_scale=[100.0, 10.0, 100.0])
    return found.x, 1.0 - float(np.var(found.fun) / np.var(angle))


def row(name: str, numbers: np.ndarray, fit: str) -> str:
    """Return one line of the table."""
    a, b, c = numbers
    frequency = math.sqrt(-a)
    return f"| {name} | {a:.0f} | {b:.1f} | {c:.0f} | {frequency:.1f} | {-b / (2.0 * frequency):.2f} | {-c / a:.2f} | {fit} |"


def main() -> None:
    """Print the table."""
    print("| vehicle | a, 1/s2 | b, 1/s | c, 1/s2 | rad/s | damping ratio | gain at rest | variance explained |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|")
    for name, numbers in REAL.items():
        print(row(f"real {name}", np.array(numbers), ""))
    systems = {name: study(name).system for name in AIRFRAMES}
    systems["as measured"] = as_measured(systems["crazyflie-pybullet"])
    spec = study(AIRFRAMES[0]).scenarios[0].spec
    for name, system in systems.items():
        numbers, share = fitted(*flown(system, spec), system.timing.control_period)
        print(row(name, numbers, f"{share:.3f}"))


if __name__ == "__main__":
    main()
