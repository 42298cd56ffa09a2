"""The cascade: geometry between position and attitude loops, signs, limits, symmetry, attitude mode."""

from math import atan, cos, hypot, pi, radians, sin, tan
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plant.law_registry import LAWS
from plant.quadrotor.attitude import euler_angles
from plant.quadrotor.cascade import MIN_LIFT, applied_acceleration, hovering, limit_to_cone, tilt_for
from plant.quadrotor.closed_loop import hover_body
from plant.quadrotor.gains import default_row
from plant.quadrotor.nominal import ControlOptions, Nominal, nominal
from plant.quadrotor.sensors import Measurement, Noise, measure
from plant.records import flatten, pack
from plant.references.track import Reference
from plant.vectors import Quaternion, Rotors, Vec3
from tests.plant.harness import HUMMINGBIRD, PAIRS, VEHICLES, ZERO, H, loop_of
from tests.plant.pilot import Array, Quadrotor, matrix_of

G = 9.81
NO_NOISE = pack(Noise, [0.0] * 12)
HERE = Reference(ZERO, ZERO, ZERO, 0.0, 0.0, 0.0, 0.0, 1.0)


def attitude(roll: float, pitch: float, yaw: float) -> Quaternion:
    x, y, z, w = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_quat().tolist()
    return Quaternion(w, x, y, z)


def seen(know: Nominal, position: Vec3 = ZERO, q: Quaternion | None = None) -> Measurement:
    """What is measured without error at rest somewhere."""
    body = hover_body(know)._replace(position=position, attitude=q or Quaternion(1.0, 0.0, 0.0, 0.0))
    return measure(body, euler_angles(body.attitude), body.rate, NO_NOISE)


def constants_of(cascade: Any) -> Any:
    return cascade.prepare(pack(cascade.Gains, default_row(cascade)), H)


def first_command(
    pair: tuple[str, str], reference: Reference, measured: Measurement, know: Nominal
) -> tuple[Array, Any]:
    """Rotor thrusts and memory after the first period, started at what is measured."""
    cascade = loop_of(*pair).cascade
    constants = constants_of(cascade)
    memory = cascade.start(constants, measured, know, hovering(know))
    level = Rotors(know.hover, know.hover, know.hover, know.hover)
    command, after = cascade.step(memory, constants, know, reference, measured, level, H)
    return np.array(command), after


def known(**options: Any) -> Nominal:
    return nominal(HUMMINGBIRD, ControlOptions(**options), H)


def test_tilt_is_the_inverse_of_the_thrust_direction() -> None:
    rng = np.random.default_rng(1)
    for roll, pitch, yaw, lift in rng.uniform([-0.9, -0.9, -pi, 3.0], [0.9, 0.9, pi, 30.0], (100, 4)):
        force = lift * matrix_of(attitude(roll, pitch, yaw))[:, 2]
        tilt = tilt_for(Vec3(force[0], force[1], force[2] - G), Vec3(cos(yaw), sin(yaw), 0.0), G)
        np.testing.assert_allclose(tilt, [roll, pitch], rtol=0.0, atol=1e-14)


def test_demands_beyond_the_cone_are_shortened_onto_it() -> None:
    tangent = tan(radians(30.0))
    rng = np.random.default_rng(2)
    inside = 0
    for x, y, z in rng.normal(0.0, [6.0, 6.0, 4.0], (300, 3)).tolist():
        limited = limit_to_cone(Vec3(x, y, z), G, tangent)
        lift = limited.z + G
        assert limited.z == max(z, (MIN_LIFT - 1.0) * G)
        assert hypot(limited.x, limited.y) <= tangent * lift * (1.0 + 1e-12)
        assert limited.x * y == pytest.approx(limited.y * x, abs=1e-12)
        assert limited.x * x + limited.y * y >= 0.0
        if hypot(x, y) < tangent * lift * (1.0 - 1e-9):
            assert (limited.x, limited.y) == (x, y)
            inside += 1
        else:
            tilt = tilt_for(limited, Vec3(1.0, 0.0, 0.0), G)
            leaning = np.arccos(cos(tilt.roll) * cos(tilt.pitch))
            assert leaning == pytest.approx(atan(tangent), rel=1e-9)
    assert 50 < inside < 250


@pytest.mark.parametrize("name", VEHICLES)
@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
def test_hover_at_the_reference_is_a_fixed_point(pair: tuple[str, str], name: str) -> None:
    # Rounding only: thrust 1e-15 of the hover thrust, and what the observers make of it, amplified by l3 < 1e3.
    know = nominal(VEHICLES[name], ControlOptions(), H)
    cascade = loop_of(*pair).cascade
    place = Vec3(1.5, -2.0, 3.0)
    measured = seen(know, place)
    before = cascade.start(constants_of(cascade), measured, know, hovering(know))
    command, after = first_command(pair, HERE._replace(position=place), measured, know)
    np.testing.assert_allclose(command, know.hover, rtol=1e-12)
    np.testing.assert_allclose(flatten(after), flatten(before), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
def test_the_vehicle_leans_and_turns_to_where_it_is_asked_to(pair: tuple[str, str]) -> None:
    know = known()
    rotors = HUMMINGBIRD.rotor_x, HUMMINGBIRD.rotor_y
    front, left = (np.array(axis) > 0.0 for axis in rotors)

    def asked(**change: Any) -> tuple[Array, Any]:
        return first_command(pair, HERE._replace(**change), seen(know), know)

    command, after = asked(position=Vec3(0.3, 0.0, 0.0))
    assert after.tilt.pitch > 0.0 and abs(after.tilt.roll) < 1e-12
    assert command[~front].min(axis=0) > command[front].max(axis=0)
    command, after = asked(position=Vec3(0.0, 0.3, 0.0))
    assert after.tilt.roll < 0.0 and abs(after.tilt.pitch) < 1e-12
    assert command[~left].min(axis=0) > command[left].max(axis=0)
    command, _ = asked(position=Vec3(0.0, 0.0, 0.1))
    assert command.min(axis=0) > know.hover
    command, _ = asked(yaw=0.02)
    spin = np.array(HUMMINGBIRD.spin)
    assert (spin * (command - know.hover) > 0.0).all()
    assert np.sum(command, axis=0) == pytest.approx(4.0 * know.hover, rel=1e-12)


@pytest.mark.parametrize("yaw", [0.0, 0.8, -2.5])
def test_the_thrust_at_the_tilt_asked_for_gives_the_acceleration_asked_for(yaw: float) -> None:
    """Once the vehicle leans as asked, thrust along its axis over mass less gravity is the demand of the position loops."""
    pair, know = ("pid", "ladrc"), known(tilt_limit=0.8)
    reference = HERE._replace(position=Vec3(0.8, -1.1, 0.4), yaw=yaw)
    cascade = loop_of(*pair).cascade
    gains = pack(cascade.Gains, default_row(cascade))
    gains = gains._replace(**{axis: getattr(gains, axis)._replace(ki=0.0) for axis in ("x", "y", "z")})
    constants = cascade.prepare(gains, H)
    level = seen(know, q=attitude(0.0, 0.0, yaw))
    held = Rotors(know.hover, know.hover, know.hover, know.hover)
    _, first = cascade.step(
        cascade.start(constants, level, know, hovering(know)), constants, know, reference, level, held, H
    )
    leaning = seen(know, q=attitude(first.tilt.roll, first.tilt.pitch, yaw))
    command, second = cascade.step(
        cascade.start(constants, leaning, know, hovering(know)), constants, know, reference, leaning, held, H
    )
    assert hypot(first.tilt.roll, first.tilt.pitch) > 0.2
    felt = sum(command) / HUMMINGBIRD.mass * np.array(leaning.thrust_direction) - [0.0, 0.0, G]
    np.testing.assert_allclose(felt, second.acceleration, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(second.acceleration, first.acceleration, rtol=0.0, atol=1e-12)


def turned(a: Vec3) -> Vec3:
    """A quarter turn to the left about z."""
    return Vec3(-a.y, a.x, a.z)


@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
def test_a_world_turned_by_a_quarter_gives_the_same_commands(pair: tuple[str, str]) -> None:
    # Angles of order 1 move by pi/2 with a rounding of 2e-16, which gains of at most 1e3 amplify.
    know, cascade = known(), loop_of(*pair).cascade
    constants, rng = constants_of(cascade), np.random.default_rng(3)
    hover = Rotors(know.hover, know.hover, know.hover, know.hover)
    memories: list[Any] = []
    for k in range(25):
        q = attitude(*rng.normal(0.0, [0.1, 0.1, 0.3]).tolist())
        body = hover_body(know)._replace(
            position=Vec3(*rng.normal(0.0, 0.1, 3).tolist()),
            velocity=Vec3(*rng.normal(0.0, 0.1, 3).tolist()),
            attitude=q,
        )
        m = measure(body, euler_angles(q), body.rate, NO_NOISE)
        reference = pack(Reference, [*rng.normal(0.0, 0.1, 9).tolist(), 0.0, 0.0, 0.2, 0.1, 1.0])
        other_m = m._replace(
            position=turned(m.position),
            velocity=turned(m.velocity),
            angles=m.angles._replace(z=m.angles.z + pi / 2),
            thrust_direction=turned(m.thrust_direction),
            heading=turned(m.heading),
        )
        other = reference._replace(
            position=turned(reference.position),
            velocity=turned(reference.velocity),
            acceleration=turned(reference.acceleration),
            yaw=reference.yaw + pi / 2,
        )
        if k == 0:
            memories = [cascade.start(constants, each, know, hovering(know)) for each in (m, other_m)]
        first, memories[0] = cascade.step(memories[0], constants, know, reference, m, hover, H)
        second, memories[1] = cascade.step(memories[1], constants, know, other, other_m, hover, H)
        np.testing.assert_allclose(second, first, rtol=0.0, atol=1e-10 * know.thrust_max)


@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
def test_attitude_mode_tracks_the_given_tilt_and_forgets_x_and_y(pair: tuple[str, str]) -> None:
    know, cascade = known(), loop_of(*pair).cascade
    constants = constants_of(cascade)
    reference = HERE._replace(roll=0.1, pitch=-0.2, hold=0.0)
    commands = []
    for stray in (0.0, 7.0):
        memory = cascade.start(constants, seen(know), know, hovering(know))
        flown, force = [], Rotors(know.hover, know.hover, know.hover, know.hover)
        for k in range(20):
            place = Vec3(stray * sin(k), stray * cos(k), 0.01 * k)
            command, memory = cascade.step(memory, constants, know, reference, seen(know, place), force, H)
            assert memory.tilt == (0.1, -0.2)
            if pair[0] == "pid":
                assert memory.x.integral == memory.y.integral == 0.0  # nothing winds up that is not tracked
            flown.append(command)
        commands.append(flown)
    np.testing.assert_array_equal(commands[0], commands[1])


@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
@pytest.mark.parametrize("turns", [-1, 1, 3])
def test_whole_turns_of_the_yaw_reference_change_nothing(pair: tuple[str, str], turns: int) -> None:
    """A heading of 370 deg is a heading of 10 deg."""
    know = known()
    near, _ = first_command(pair, HERE._replace(yaw=0.17), seen(know), know)
    far, _ = first_command(pair, HERE._replace(yaw=0.17 + 2.0 * pi * turns), seen(know), know)
    np.testing.assert_allclose(far, near, rtol=0.0, atol=1e-10 * know.thrust_max)


@pytest.mark.parametrize("rates", ["measured", "observer"])
@pytest.mark.parametrize("law", LAWS)
def test_a_yaw_step_past_half_a_turn_does_not_shock_the_loop(law: str, rates: str) -> None:
    """Settled at 0 and then asked for 200 deg, the vehicle turns the short way, as when it is asked for -160 deg."""
    know, cascade = known(attitude_rate=rates), loop_of("pid", law).cascade
    constants = constants_of(cascade)
    level = Rotors(know.hover, know.hover, know.hover, know.hover)
    torques = []
    for goal in (radians(200.0), radians(-160.0)):
        memory = cascade.start(constants, seen(know), know, hovering(know))
        for yaw in (0.0, 0.0, goal, goal, goal):
            command, memory = cascade.step(memory, constants, know, HERE._replace(yaw=yaw), seen(know), level, H)
            achieved = HUMMINGBIRD.torque_ratio * np.array(HUMMINGBIRD.spin) @ np.array(command)
            torques.append(achieved - memory.actuators.torque_excess.z)
    # A law that filters what its outer gain asks for begins gently: 0.013 N m against 0.1 and more.
    assert abs(torques[2]) > 0.01
    np.testing.assert_allclose(torques[:5], torques[5:], rtol=0.0, atol=1e-9)


def test_what_the_position_observers_are_told() -> None:
    """Lag-aware: modelled thrust along the measured axis. Otherwise: the acceleration asked for, and the thrust commanded."""
    lean = Vec3(sin(0.2), 0.0, cos(0.2))
    hover = HUMMINGBIRD.mass * G / 4.0
    commanded, modelled = Rotors(*[1.1 * hover] * 4), Rotors(*[1.2 * hover] * 4)
    asked = Vec3(0.7, -0.3, 0.1)
    aware = applied_acceleration(commanded, modelled, lean, asked, known())
    np.testing.assert_allclose(aware, [1.2 * G * sin(0.2), 0.0, 1.2 * G * cos(0.2) - G], rtol=0.0, atol=1e-14)
    unaware = applied_acceleration(commanded, modelled, lean, asked, known(lag_aware=False))
    np.testing.assert_allclose(unaware, [0.7, -0.3, 1.1 * G * cos(0.2) - G], rtol=0.0, atol=1e-14)


def torque_asked(command: Array, after: Any) -> Array:
    """Body torque that the attitude laws asked for, before limits."""
    return Quadrotor(HUMMINGBIRD).mixer[1:] @ command - np.array(after.actuators.torque_excess)


def test_each_attitude_law_is_told_the_inertia_of_its_own_axis() -> None:
    """LADRC at rest asks for wc^2 times the error as acceleration, so for I wc^2 e as torque; wc = 6 rad/s by default."""
    know = known()
    vehicle = HUMMINGBIRD._replace(inertia=Vec3(0.003, 0.004, 0.006))
    know = know._replace(vehicle=vehicle)
    reference = HERE._replace(roll=0.01, pitch=-0.02, yaw=0.03, hold=0.0)
    command, after = first_command(("pid", "ladrc"), reference, seen(know), know)
    expected = 36.0 * np.array([0.003 * 0.01, -0.004 * 0.02, 0.006 * 0.03])
    np.testing.assert_allclose(torque_asked(command, after), expected, rtol=0.0, atol=1e-15)


def test_what_limits_took_away_is_remembered() -> None:
    """Far beyond the cone and the rotors: excess is what was clipped less what was asked for."""
    know = known(tilt_limit=0.3)
    command, after = first_command(("pid", "ladrc"), HERE._replace(position=Vec3(50.0, 0.0, 0.0)), seen(know), know)
    # kp e = 2.5 x 50 m/s2 is asked for, g tan(0.3) is left on the cone; then the attitude law asks for I wc^2 x 0.3 rad.
    assert after.tilt.pitch == pytest.approx(0.3, rel=1e-6)
    assert after.actuators.acceleration_excess.x == pytest.approx(G * tan(0.3) - 125.0, rel=1e-6)
    assert torque_asked(command, after)[1] == pytest.approx(36.0 * 0.3 * HUMMINGBIRD.inertia.y, rel=1e-6)
    # Straight up all four rotors stop at their limit, and the position law hears of it.
    command, after = first_command(("pid", "ladrc"), HERE._replace(position=Vec3(0.0, 0.0, 50.0)), seen(know), know)
    np.testing.assert_allclose(command, know.thrust_max, rtol=1e-12)
    reached = 4.0 * know.thrust_max / HUMMINGBIRD.mass - G
    assert after.actuators.acceleration_excess.z == pytest.approx(reached - 125.0, rel=1e-9)
