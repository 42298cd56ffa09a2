"""One flight as a sampled system: status, delay, meters, equilibria, and the symmetries that space has."""

from math import cos, pi, radians, sin
from typing import Any

import numpy as np
import pytest

from plant.backends import array
from plant.backends.flyer import Flyer, result_parts
from plant.backends.stepping import fly_steps, unchanged
from plant.quadrotor.cascade import Tilt
from plant.quadrotor.closed_loop import LARGEST_STATE, CascadeLoop, Limits, hover_body, place, sample_of, status_of
from plant.quadrotor.gains import default_row
from plant.quadrotor.nominal import ControlOptions, nominal, yaw_lead
from plant.quadrotor.rigid_body import Body
from plant.quadrotor.sensors import Noise
from plant.records import flatten, index, pack
from plant.references.track import Reference
from plant.status import Status
from plant.vectors import Quaternion, Rotors, Vec3
from tests.plant.harness import (
    HUMMINGBIRD,
    LIMITS,
    PAIRS,
    TARGETS,
    TIMING,
    VEHICLES,
    ZERO,
    Array,
    H,
    batch,
    default_gains,
    in_blocks,
    loop_of,
    references,
    scenario,
    unmetered,
)

HERE = Reference(ZERO, ZERO, ZERO, 0.0, 0.0, 0.0, 0.0, 1.0)
LEVEL = Quaternion(1.0, 0.0, 0.0, 0.0)
NAN = float("nan")


def calm(steps: int, count: int = 1) -> Array:
    return np.zeros((count, steps, 12))


def weather(steps: int, count: int, seed: int) -> tuple[Array, Array]:
    """Disturbances and noises (count, steps, 12) at the size that flights meet."""
    rng = np.random.default_rng(seed)
    air = rng.standard_normal((count, steps, 12)) * np.repeat([2.0, 0.1, 0.3, 1.0], 3)
    return air, rng.standard_normal((count, steps, 12)) * np.repeat([0.002, 0.01, 0.002, 0.01], 3)


def history(loop: CascadeLoop, inputs: Any, know: Any, limits: Limits = LIMITS) -> list[Any]:
    """The Flight record of every control instant, in plain floats."""
    seen: list[Any] = []
    fly_steps(
        loop,
        unchanged,
        default_gains(loop),
        know,
        scenario(inputs, 0),
        TARGETS,
        limits,
        TIMING,
        lambda k, flight: seen.append(flight),
    )
    return seen


def leaning(angle: float) -> Quaternion:
    return Quaternion(cos(angle / 2.0), 0.6 * sin(angle / 2.0), -0.8 * sin(angle / 2.0), 0.0)


def body(position: Vec3 = ZERO, velocity: Vec3 = ZERO, q: Quaternion = LEVEL, rate: Vec3 = ZERO) -> Body:
    return Body(position, velocity, q, rate, Rotors(1.0, 1.0, 1.0, 1.0))


FREE = HERE._replace(hold=0.0)
AWAY, TURNED = Vec3(0.0, -5.1, 0.0), leaning(radians(81.0))


@pytest.mark.parametrize(
    ("state", "reference", "status"),
    [
        (body(), HERE, Status.COMPLETED),
        (body(Vec3(4.9, -4.9, 4.9)), HERE, Status.COMPLETED),
        (body(Vec3(105.1, 0.0, 0.0)), HERE._replace(position=Vec3(101.0, 0.0, 0.0)), Status.COMPLETED),
        (body(Vec3(0.0, 105.1, 0.0)), HERE._replace(position=Vec3(0.0, 101.0, 0.0)), Status.COMPLETED),
        (body(Vec3(0.0, 0.0, 105.1)), HERE._replace(position=Vec3(0.0, 0.0, 101.0)), Status.COMPLETED),
        (body(Vec3(5.1, 0.0, 0.0)), HERE, Status.LOST),
        (body(AWAY), HERE, Status.LOST),
        (body(Vec3(0.0, 0.0, 5.1)), HERE, Status.LOST),
        (body(AWAY), FREE, Status.COMPLETED),
        (body(Vec3(0.0, 0.0, -5.1)), FREE, Status.LOST),
        (body(q=leaning(radians(79.0))), HERE, Status.COMPLETED),
        (body(q=TURNED), HERE, Status.TILTED),
        (body(AWAY, q=TURNED), HERE, Status.TILTED),
        (body(AWAY, velocity=Vec3(0.0, NAN, 0.0), q=TURNED), HERE, Status.NON_FINITE),
        (body(Vec3(NAN, 0.0, 0.0)), HERE, Status.NON_FINITE),
        (body(rate=Vec3(0.0, 0.0, float("inf"))), HERE, Status.NON_FINITE),
        (body(Vec3(NAN, 0.0, 0.0)), FREE, Status.NON_FINITE),
        (body(velocity=Vec3(1.01 * LARGEST_STATE**0.5, 0.0, 0.0)), HERE, Status.NON_FINITE),
    ],
)
def test_status_of_a_state(state: Body, reference: Reference, status: Status) -> None:
    """Non-finite outranks tilt, tilt outranks position; a free axis cannot be lost."""
    assert status_of(state, reference, LIMITS) == status.code
    lane = array.rebinder()(status_of)(pack(Body, [np.array([leaf]) for leaf in flatten(state)]), reference, LIMITS)
    assert lane == status.code


def test_codes_are_the_places_in_the_enum_and_values_are_sentences() -> None:
    assert [status.code for status in Status] == [0, 1, 2, 3]
    assert Status.COMPLETED.code == 0
    assert all(len(status.value.split()) > 3 for status in Status)


def test_a_status_once_met_is_kept_and_the_meters_stand_still() -> None:
    know, loop = nominal(HUMMINGBIRD, ControlOptions(), H), unmetered("pid", "pid")
    # Sideways blasts of 30 m/s2: away beyond 0.2 m first, tilted beyond the limit and back later.
    air = calm(250)
    air[0, 25:75, 6], air[0, 100:200, 9] = 30.0, 40.0
    flown = history(loop, batch([HUMMINGBIRD], air, calm(250), references(250)), know, Limits(0.2, cos(radians(30.0))))
    status = [int(flight.status) for flight in flown]
    first = next(k for k, code in enumerate(status) if code)
    assert set(status[:first]) == {0}
    assert set(status[first:]) == {Status.LOST.code}
    after = [status_of(flight.body, HERE, Limits(0.2, cos(radians(30.0)))) for flight in flown[first:]]
    assert Status.TILTED.code in after  # it would have been overwritten
    for flight in flown[first:]:
        assert flight.meters == flown[first - 1].meters
        assert flight.end_time == flown[first - 1].end_time == pytest.approx(first * H, rel=1e-12)


@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
def test_a_delay_of_one_period_is_one_period(pair: tuple[str, str]) -> None:
    """A reference that jumps at instant 10 changes the motion from instant 11 on, with delay from 12 on."""
    loop, jump, steps = unmetered(*pair), 10, 15
    asked = references(steps, z=0.0)
    asked[jump:, 2] = 0.5
    first = {}
    for delay in (False, True):
        know = nominal(HUMMINGBIRD, ControlOptions(delay=delay), H)
        flown = [
            history(loop, batch([HUMMINGBIRD], calm(steps), calm(steps), rows), know)
            for rows in (references(steps), asked)
        ]
        moved = [a.body.velocity != b.body.velocity for a, b in zip(*flown, strict=True)]
        first[delay] = moved.index(True)
        # What acts at k is what was decided at k, or at k - 1.
        for k in range(1, steps):
            assert flown[1][k].in_force == flown[1][k - delay].pending
    assert first == {False: jump + 1, True: jump + 2}


@pytest.mark.parametrize("name", VEHICLES)
@pytest.mark.parametrize("pair", [("pid", "hybrid"), ("hybrid", "ladrc"), ("ladrc", "pid")], ids="-".join)
def test_in_calm_air_hover_is_held_to_rounding(pair: tuple[str, str], name: str) -> None:
    # Rounding of the thrust sum, 1e-15 g, over 0.2 s: 1e-16 m; attitude loops multiply that of their torques by at
    # most 1e3.
    know, vehicle = nominal(VEHICLES[name], ControlOptions(delay=True), H), VEHICLES[name]
    last = history(unmetered(*pair), batch([vehicle], calm(50), calm(50), references(50)), know)[-1]
    np.testing.assert_allclose(flatten(last.body)[:13], [0.0] * 6 + [1.0] + [0.0] * 6, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(last.pending, know.hover, rtol=1e-11)
    assert last.end_time == pytest.approx(50 * H, rel=1e-12)


def test_meters_see_the_truth_and_not_the_measurement() -> None:
    """With a bias of 0.3 m on measured x the loop settles at -0.3 m, and the meters say so."""
    know, loop = nominal(HUMMINGBIRD, ControlOptions(), H), loop_of("ladrc", "ladrc")
    steps, noise = 1000, calm(1000)
    noise[..., 0] = 0.3
    last = history(loop, batch([HUMMINGBIRD], calm(steps), noise, references(steps)), know)[-1]
    assert last.body.position.x == pytest.approx(-0.3, abs=0.01)
    assert last.meters.x.previous == last.body.position.x
    assert last.meters.x.peak == pytest.approx(0.3, abs=0.01)


def test_commands_are_shown_in_hover_thrusts_with_their_predecessors() -> None:
    know = nominal(HUMMINGBIRD, ControlOptions(), H)
    now = Rotors(*(know.hover * f for f in (1.0, 1.5, 0.5, 2.0)))
    before = Rotors(*(know.hover * f for f in (1.0, 1.0, 1.2, 0.8)))
    sample = sample_of(body(), Vec3(0.01, 0.02, 6.2), HERE, Tilt(0.1, 0.2), now, before, know, 0.4)
    np.testing.assert_allclose(sample.command, [1.0, 1.5, 0.5, 2.0], rtol=1e-14)
    np.testing.assert_allclose(sample.previous, [1.0, 1.0, 1.2, 0.8], rtol=1e-14)
    assert (sample.time, sample.saturated) == (0.4, 0.0)
    assert (sample.roll, sample.pitch) == ((0.1, 0.01), (0.2, 0.02))
    assert sample.yaw.actual == pytest.approx(6.2 - 2.0 * np.pi, rel=1e-12)
    assert (
        sample_of(body(), ZERO, HERE, Tilt(0.0, 0.0), now._replace(r3=know.thrust_min), before, know, 0.0).saturated
        == 1.0
    )


@pytest.mark.parametrize("delay", [False, True])
def test_travel_sums_the_changes_of_successive_commands(delay: bool) -> None:
    """Decided commands, in hover thrusts, from the level ones before the flight on; the delay of their effect plays no part."""
    know, loop = nominal(HUMMINGBIRD, ControlOptions(delay=delay), H), loop_of("ladrc", "hybrid")
    air, noise = weather(40, 1, seed=4)
    flown = history(loop, batch([HUMMINGBIRD], air, noise, references(40, x=0.2)), know)
    commands = np.array([[1.0] * 4, *[np.array(flight.pending) / know.hover for flight in flown]])
    travel = np.abs(np.diff(commands, axis=0)).sum(axis=(0, 1))
    assert travel > 0.5
    assert flown[-1].meters.travel == pytest.approx(travel, rel=1e-12)


@pytest.mark.parametrize("delay", [False, True])
def test_the_observers_are_told_what_the_rotors_deliver(delay: bool) -> None:
    # Without drag or noise there is no disturbance to find, so all that z3 shows is the error of the actuator model: thrust
    # is taken to lag linearly where the rotor speed does, an error of second order. Measured: 0.9 % (roll), 0.6 % (pitch),
    # 2.2 % (yaw, which swings the rotors most) of the acceleration; with a mean or an end of the period that is wrong, 5 %
    # and more.
    vehicle = HUMMINGBIRD._replace(drag_linear=ZERO, drag_quadratic=ZERO, rotor_inertia=0.0)
    know, loop = nominal(vehicle, ControlOptions(delay=delay), H), unmetered("ladrc", "ladrc")
    steps = 250
    t = np.arange(steps) * H
    asked = references(steps, hold=0.0)
    asked[:, 9], asked[:, 10], asked[:, 11] = 0.1 * np.sin(9.0 * t), 0.1 * np.sin(6.0 * t), 0.1 * np.sin(4.0 * t)
    flown = history(loop, batch([vehicle], calm(steps), calm(steps), asked), know)
    rates = np.array([flight.body.rate for flight in flown])
    seen = np.abs(np.diff(rates, axis=0)).max(axis=0) / H
    found = np.array([[getattr(flight.control, axis).z3 for axis in ("roll", "pitch", "yaw")] for flight in flown])
    assert (np.abs(found).max(axis=0) < 0.035 * seen).all()


def test_a_free_axis_has_no_error() -> None:
    know = nominal(HUMMINGBIRD, ControlOptions(), H)
    hover = Rotors(know.hover, know.hover, know.hover, know.hover)
    sample = sample_of(body(Vec3(1.0, 2.0, 3.0)), ZERO, FREE, Tilt(0.0, 0.0), hover, hover, know, 0.0)
    assert sample.x == (1.0, 1.0)
    assert sample.y == (2.0, 2.0)
    assert sample.z == (0.0, 3.0)


def test_a_flight_starts_where_its_reference_does() -> None:
    know = nominal(HUMMINGBIRD, ControlOptions(), H)
    placed = place(hover_body(know), HERE._replace(position=Vec3(1.0, -2.0, 3.0)))
    assert placed.position == (1.0, -2.0, 3.0)
    assert placed.rotor_speed.r1**2 * HUMMINGBIRD.thrust_coefficient == pytest.approx(
        HUMMINGBIRD.mass * HUMMINGBIRD.gravity / 4.0, rel=1e-14
    )


MOVED = np.array([64.0, -32.0, 16.0])
STEPS = 60


def end_of(pair: tuple[str, str], air: Array, noise: Array, reference: Array) -> Array:
    """Body states (lanes, 17) at the end of flights in numpy."""
    loop = unmetered(*pair)
    inputs = batch([HUMMINGBIRD] * len(air), air, noise, reference)
    know = nominal(HUMMINGBIRD, ControlOptions(delay=True), H)
    last = fly_steps(loop, array.rebinder(), default_gains(loop), know, inputs, TARGETS, LIMITS, TIMING)
    return np.array([np.broadcast_to(leaf, len(air)) for leaf in flatten(last.body)]).T


@pytest.mark.parametrize("pair", [("pid", "hybrid"), ("hybrid", "ladrc"), ("ladrc", "pid")], ids="-".join)
def test_a_flight_does_not_depend_on_where_it_is_flown(pair: tuple[str, str]) -> None:
    # Moved by 64 m a position keeps 6 bits less: 7e-15 m, fed back with gains of at most 1e3 over 0.24 s.
    air, noise = weather(STEPS, 3, seed=1)
    asked = references(STEPS, x=0.3, y=-0.2, z=0.1, yaw=0.2)
    asked[0, :3] = 0.0
    here = end_of(pair, air, noise, asked)
    asked[:, :3] += MOVED
    there = end_of(pair, air, noise, asked)
    assert np.ptp(here[:, 0], axis=0) > 1e-4
    np.testing.assert_allclose(there[:, :3] - MOVED, here[:, :3], rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(there[:, 3:13], here[:, 3:13], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("pair", [("pid", "hybrid"), ("hybrid", "ladrc"), ("ladrc", "pid")], ids="-".join)
def test_a_mirrored_flight_is_the_mirror_image(pair: tuple[str, str]) -> None:
    """Left and right exchanged: y, roll, yaw and their rates change sign, in air, noise and reference too.

    The vehicle is its own mirror image: the rotors of a pair left and right turn against each other.
    """
    air, noise = weather(STEPS, 3, seed=2)
    asked = references(STEPS, x=0.3, y=-0.2, z=0.1, yaw=0.2)
    asked[0, :3] = 0.0
    here = end_of(pair, air, noise, asked)
    vector, axial = np.array([1.0, -1.0, 1.0]), np.array([-1.0, 1.0, -1.0])
    other_air = air * np.concatenate([vector, axial, vector, axial])
    other_noise = noise * np.concatenate([vector, vector, axial, axial])
    other = asked.copy()
    other[:, [1, 11]] *= -1.0
    mirrored = end_of(pair, other_air, other_noise, other)
    quaternion = np.array([1.0, -1.0, 1.0, -1.0])
    signs = np.concatenate([vector, vector, quaternion, axial])
    np.testing.assert_allclose(mirrored[:, :13] * signs, here[:, :13], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(mirrored[:, [14, 13, 16, 15]], here[:, 13:], rtol=1e-9)


@pytest.mark.parametrize("name", VEHICLES)
def test_default_gains_fly_every_airframe_to_a_step(name: str) -> None:
    # 1 m aside and up and 30 deg of yaw in light wind; 8 s are six of the slowest time constants, and the wind's own
    # error is centimetres. Where the rotors' inertia leads below 50 rad/s the low-pass on yaw torque takes that back.
    vehicle, steps, loop = VEHICLES[name], 2000, loop_of("ladrc", "hybrid")
    lead = yaw_lead(vehicle)
    know = nominal(vehicle, ControlOptions(delay=True, yaw_torque_cutoff=lead / (2.0 * pi) if lead < 50.0 else 0.0), H)
    asked = references(steps, x=1.0, y=-1.0, z=1.0, yaw=0.5)
    asked[:25] = references(25)
    air = calm(steps)
    air[..., 0] = 0.5
    inputs = in_blocks(batch([vehicle], air, calm(steps), asked))
    flyer = Flyer(loop, LIMITS, TIMING, 1)
    gains = np.array(default_row(loop.cascade))
    _, status, _ = result_parts(flyer.fly(gains[None], know, inputs)[0])
    assert status.tolist() == [Status.COMPLETED.code]
    last = flyer.trace(gains, know, inputs)[0, -1]
    found = [last[index(loop.Flight, f"body.position.{axis}")] for axis in "xyz"]
    np.testing.assert_allclose(found, [1.0, -1.0, 1.0], atol=0.02)
    assert last[index(loop.Flight, "meters.yaw.previous")] == pytest.approx(0.5, abs=0.01)


def test_noise_columns_are_those_of_the_record() -> None:
    assert index(Noise, "angles.x") == 6 and index(Noise, "rate.z") == 11
