"""Dead time of the rotors: whole control periods between the command in force and the speed that rotors turn towards."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from objectives import meters
from plant.backends.flyer import Flyer
from plant.backends.stepping import fly_steps, unchanged
from plant.errors import InputError
from plant.loop import MeterModel
from plant.quadrotor.airframes import load
from plant.quadrotor.closed_loop import CascadeLoop, close_loop
from plant.quadrotor.features import VehicleFeatures, vehicle_features
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.vehicle import Vehicle, late_periods
from plant.records import flatten
from tests.plant.harness import (
    HUMMINGBIRD,
    LIMITS,
    TARGETS,
    TIMING,
    H,
    batch,
    default_gains,
    in_blocks,
    loop_of,
    references,
    scenario,
)

STEPS, JUMP = 40, 10
PROMPT = nominal(HUMMINGBIRD, ControlOptions(), H)


def late_loop(late: int) -> CascadeLoop:
    return close_loop(
        loop_of("pid", "pid").cascade, MeterModel(meters.Meters, meters.start, meters.update), VehicleFeatures(late)
    )


def varied_loop(most: int) -> CascadeLoop:
    return close_loop(
        loop_of("pid", "pid").cascade,
        MeterModel(meters.Meters, meters.start, meters.update),
        VehicleFeatures(most_delay_steps=most),
    )


def flown(loop: CascadeLoop, know: Any, step: float, vehicle: Vehicle = HUMMINGBIRD) -> list[Any]:
    """The Flight record of every control instant of a flight up by a step [m]."""
    asked = references(STEPS, z=0.0)
    asked[JUMP:, 2] = step
    calm, seen = np.zeros((1, STEPS, 12)), []
    inputs = scenario(batch([vehicle], calm, calm, asked), 0)
    fly_steps(
        loop,
        unchanged,
        default_gains(loop),
        know,
        inputs,
        TARGETS,
        LIMITS,
        TIMING,
        lambda k, flight: seen.append(flight),
    )
    return seen


@pytest.mark.parametrize("late", [0, 1, 3])
def test_motion_begins_so_many_periods_later(late: int) -> None:
    """A reference that jumps at instant 10 moves the vehicle from instant 11 on, with dead time as many periods later."""
    still, moving = (flown(late_loop(late), PROMPT, step) for step in (0.0, 0.5))
    changed = [a.body.velocity != b.body.velocity for a, b in zip(still, moving, strict=True)]
    assert changed.index(True) == JUMP + 1 + late


def test_one_period_of_dead_time_moves_the_vehicle_as_one_of_computing() -> None:
    """Away from limits a PID does not ask what the rotors deliver, so it cannot tell the two."""
    computing = flown(late_loop(0), nominal(HUMMINGBIRD, ControlOptions(delay=True), H), 0.05)
    waiting = flown(late_loop(1), PROMPT, 0.05)
    assert [flight.body for flight in waiting] == [flight.body for flight in computing]
    assert waiting[-1].body.position.z > 1e-4


@pytest.mark.parametrize("periods", [0, 1, 3])
def test_vehicles_of_one_loop_have_dead_times_of_their_own(periods: int) -> None:
    """A loop for up to three periods flies each vehicle to the last bit as the loop of its own dead time does."""
    vehicle = HUMMINGBIRD._replace(dead_time=(periods + 0.2) * H)
    varied = flown(varied_loop(3), PROMPT, 0.5, vehicle)
    assert [flight.body for flight in varied] == [flight.body for flight in flown(late_loop(periods), PROMPT, 0.5)]


def test_the_longest_dead_time_that_is_drawn_decides_the_length_of_the_line() -> None:
    """Three standard deviations above the file's, at most 64 periods; none where no dead time is drawn."""
    vehicle = HUMMINGBIRD._replace(dead_time=0.004, dead_time_deviation=0.003)
    assert [vehicle_features(vehicle, h).most_delay_steps for h in (0.0002, 0.001, 0.002, 0.004)] == [64, 13, 6, 3]
    assert vehicle_features(vehicle, 0.004).name == "_upto3late"
    assert vehicle_features(HUMMINGBIRD._replace(dead_time=0.004), 0.004).most_delay_steps == 0


@pytest.mark.slow
def test_lanes_fly_the_queue() -> None:
    """Kernels and plain Python agree on every meter of flights with three and one periods of dead time in one loop."""
    loop, calm, reference = varied_loop(3), np.zeros((1, STEPS, 12)), references(STEPS, z=0.0)
    reference[JUMP:, 2] = 0.5
    vehicles = [HUMMINGBIRD._replace(dead_time=periods * H) for periods in (3.0, 1.0)]
    inputs = in_blocks(batch(vehicles, np.repeat(calm, 2, axis=0), np.repeat(calm, 2, axis=0), reference))
    lanes = Flyer(loop, LIMITS, TIMING, 1).fly(np.array([flatten(default_gains(loop))]), PROMPT, inputs)
    for flight, vehicle in zip(lanes[0], vehicles, strict=True):
        meters_of = flatten(flown(loop, PROMPT, 0.5, vehicle)[-1].meters)
        assert flight[: len(meters_of)] == pytest.approx(meters_of, rel=1e-9, abs=1e-12)


def test_dead_time_is_rounded_to_whole_periods() -> None:
    """1.2 ms are one period of 1 ms and none of 4 ms; what no flight could keep is refused."""
    vehicle = HUMMINGBIRD._replace(dead_time=0.0012)
    assert [late_periods(vehicle, h) for h in (0.001, 0.002, 0.004)] == [1, 1, 0]
    with pytest.raises(InputError, match="at most 64 are kept"):
        late_periods(vehicle._replace(dead_time=0.1), 0.001)


def test_an_airframe_file_may_give_it(tmp_path: Path) -> None:
    """It is 0 where the file is silent, and cannot be negative."""
    text = load("f450").path.read_text(encoding="utf-8")
    line = 'dead_time = {{ value = {value}, unit = "s", source = "a test" }}\n\n[inertia]'
    file = tmp_path / "late.toml"
    file.write_text(text.replace("[inertia]", line.format(value=0.002), 1), encoding="utf-8")
    assert load(file).vehicle == load("f450").vehicle._replace(dead_time=0.002)
    assert load("f450").vehicle.dead_time == 0.0
    file.write_text(text.replace("[inertia]", line.format(value=-0.002), 1), encoding="utf-8")
    with pytest.raises(InputError, match="must be not negative"):
        load(file)
