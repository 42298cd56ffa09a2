"""Thrust curve of the rotors over the motor command, against the quadratic formula and finite differences of flights."""

from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from objectives import meters
from objectives.margins.period import NO_METERS
from plant.backends.flyer import Flyer
from plant.backends.stepping import fly_steps, unchanged
from plant.errors import InputError
from plant.law_registry import LAWS
from plant.loop import MeterModel, Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.closed_loop import CascadeLoop, close_loop, hover_body
from plant.quadrotor.features import vehicle_features
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.rigid_body import dynamics
from plant.quadrotor.thrust_curve import CURVED, PROPORTIONAL, command_curve, rotor_command, rotor_speed
from plant.quadrotor.vehicle import Vehicle
from plant.records import flatten
from plant.vectors import Rotors
from tests.plant.harness import (
    CALM,
    HUMMINGBIRD,
    LIMITS,
    TARGETS,
    batch,
    default_gains,
    in_blocks,
    loop_of,
    references,
    scenario,
)

H = 0.004
METER = MeterModel(meters.Meters, meters.start, meters.update)
SHARES = (-0.6, -0.1, 0.3, 0.7, 1.0)
WEIGHT = 0.25 * HUMMINGBIRD.mass * HUMMINGBIRD.gravity
FULL = HUMMINGBIRD.thrust_coefficient * HUMMINGBIRD.speed_max**2


def curved(a: float) -> Vehicle:
    return HUMMINGBIRD._replace(thrust_linear=a)


def hover_command(a: float) -> float:
    """Command that carries the weight: the root of (1 - a) u^2 + a u = W/T_max."""
    share = WEIGHT / FULL
    return share if a == 1.0 else (-a + sqrt(a * a + 4.0 * (1.0 - a) * share)) / (2.0 * (1.0 - a))


def loop_for(vehicle: Vehicle) -> CascadeLoop:
    return close_loop(close_cascade(LAWS["pid"], LAWS["pid"]), NO_METERS, vehicle_features(vehicle, H))


def flown(vehicle: Vehicle, assumed: Vehicle, goal: float = 0.0, steps: int = 200) -> list[Any]:
    """The Flight record of every control instant of a flight of a vehicle whose controller assumes another."""
    loop, none, seen = loop_for(assumed), np.zeros((1, steps, 12)), []
    fly_steps(
        loop,
        unchanged,
        default_gains(loop),
        nominal(assumed, ControlOptions(), H),
        scenario(batch([vehicle], none, none, references(steps, z=goal)), 0),
        TARGETS,
        LIMITS,
        Timing(H, H),
        lambda _, flight: seen.append(flight),
    )
    return seen


@pytest.mark.parametrize("a", SHARES)
def test_hover_takes_the_command_of_the_quadratic_formula(a: float) -> None:
    """The rotors turn as fast as ever, and exports name the same command."""
    last = flown(curved(a), curved(a))[-1]
    assert np.array(last.speed) / HUMMINGBIRD.speed_max == pytest.approx(hover_command(a), rel=1e-10)
    assert np.array(last.body.rotor_speed) == pytest.approx(sqrt(WEIGHT / HUMMINGBIRD.thrust_coefficient), rel=1e-10)
    assert actuation(curved(a)).hover_command == pytest.approx(hover_command(a), rel=1e-12)


@pytest.mark.parametrize("a", SHARES)
def test_thrust_per_command_at_hover_is_the_slope_of_the_curve(a: float) -> None:
    """T_max (2 (1 - a) u + a), found by commanding a little more and less until the rotors have settled."""
    vehicle, step = curved(a), 1e-4
    advance, f = loop_for(vehicle).advance, dynamics(vehicle)

    def thrust(u: float) -> float:
        body = hover_body(nominal(vehicle, ControlOptions(), H))
        for _ in range(400):
            body = advance(body, Rotors(*[u * vehicle.speed_max] * 4), CALM, f, 0.002)
        return vehicle.thrust_coefficient * body.rotor_speed.r1**2

    hover = hover_command(a)
    slope = (thrust(hover + step) - thrust(hover - step)) / (2.0 * step)
    assert slope == pytest.approx(FULL * (2.0 * (1.0 - a) * hover + a), rel=1e-6)
    assert actuation(vehicle).hover_slope == pytest.approx(slope, rel=1e-6)


@pytest.mark.parametrize("a", SHARES)
def test_a_controller_that_inverts_the_curve_flies_as_without(a: float) -> None:
    """Its loop has unit gain: a climb is that of the vehicle whose thrust is the square of the command."""
    bent, plain = flown(curved(a), curved(a), 0.5), flown(HUMMINGBIRD, HUMMINGBIRD, 0.5)
    height = [flight.body.position.z for flight in plain]
    assert [flight.body.position.z for flight in bent] == pytest.approx(height, rel=1e-9, abs=1e-12)
    assert max(height) > 0.1


@pytest.mark.parametrize("a", [-0.2, 0.6])
def test_a_vehicle_with_another_curve_starts_in_balance(a: float) -> None:
    """The laws hold what its hover takes by the curve that they invert."""
    seen = flown(curved(a), curved(0.3), steps=50)
    assert max(abs(flight.body.velocity.z) for flight in seen) < 1e-10
    u = hover_command(a)
    assert np.array(seen[-1].in_force) == pytest.approx(FULL * (0.7 * u * u + 0.3 * u), rel=1e-9)


@pytest.mark.parametrize("a", [-0.999, *SHARES, 0.0])
def test_command_and_speed_are_inverse(a: float) -> None:
    """From 1e-3 of the largest speed on; below the dead zone of a < 0 a rotor stands still, and none falls with its command."""
    curve = command_curve(a, 800.0)
    speeds = np.geomspace(0.8, 800.0, 30).tolist()
    assert [rotor_speed(rotor_command(w, curve), curve) for w in speeds] == pytest.approx(speeds, rel=1e-9)
    held = [rotor_speed(c, curve) for c in np.linspace(0.0, 800.0, 200).tolist()]
    assert held[0] == 0.0 and held[-1] == pytest.approx(800.0, rel=1e-12) and np.all(np.diff(held) >= 0.0)


def test_a_vehicle_without_it_has_no_curve_in_its_loop() -> None:
    assert vehicle_features(HUMMINGBIRD, H).drive is PROPORTIONAL
    assert (vehicle_features(curved(0.3), H).drive, vehicle_features(curved(0.3), H).name) == (CURVED, "_curved")


@pytest.mark.slow
def test_lanes_fly_the_curve() -> None:
    """Kernels and plain Python agree on a climb of a vehicle that its controller does not quite know."""
    vehicle, know, steps = curved(0.5), nominal(curved(0.3), ControlOptions(), H), 60
    none, timing = np.zeros((1, steps, 12)), Timing(H, 0.002)
    met = batch([vehicle], none, none, references(steps, z=0.5))
    loop = close_loop(loop_of("pid", "pid").cascade, METER, vehicle_features(vehicle, H))
    gains = default_gains(loop)
    lanes = Flyer(loop, LIMITS, timing, 1).fly(np.array([flatten(gains)]), know, in_blocks(met))
    plain = fly_steps(loop, unchanged, gains, know, scenario(met, 0), TARGETS, LIMITS, timing)
    assert np.ravel(lanes)[: len(flatten(plain.meters))] == pytest.approx(flatten(plain.meters), rel=1e-9, abs=1e-12)


def test_an_airframe_file_may_give_it(tmp_path: Path) -> None:
    """It is 0 where the file is silent; at -1 half of the commands would not turn a rotor, above 1 thrust could fall."""
    text, file = load("f450").path.read_text(encoding="utf-8"), tmp_path / "curved.toml"

    def read(value: float) -> Vehicle:
        line = f'thrust_linear = {{ value = {value}, unit = "1", source = "a test" }}\n\n[inertia]'
        file.write_text(text.replace("[inertia]", line, 1), encoding="utf-8")
        return load(file).vehicle

    assert load("f450").vehicle.thrust_linear == 0.0
    for value in (-0.99, 0.35, 1.0):
        assert read(value) == load("f450").vehicle._replace(thrust_linear=value)
    for value in (-1.0, 1.01):
        with pytest.raises(InputError, match="thrust_linear.value: is .*; it must be above -1 and at most 1"):
            read(value)
