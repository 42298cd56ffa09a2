"""Rotor thrusts, their torques, and the way back from a demand to commands within limits."""

from math import sqrt

import numpy as np
import pytest

from plant.quadrotor.allocation import allocate, saturated, speed_commands
from plant.quadrotor.nominal import ControlOptions, Nominal, nominal
from plant.quadrotor.rigid_body import rotor_thrusts, rotor_torque
from plant.quadrotor.vehicle import Vehicle
from plant.vectors import Rotors, Vec3
from tests.plant.harness import HUMMINGBIRD, VEHICLES, Array
from tests.plant.pilot import Quadrotor

DEMANDS = 400


def known(vehicle: Vehicle) -> Nominal:
    return nominal(vehicle, ControlOptions(), 0.004)


def wrench(vehicle: Vehicle, thrust: Rotors) -> Array:
    """Total thrust and torque by cross products, (4,)."""
    return Quadrotor(vehicle).mixer @ np.array(thrust)


def random_demands(vehicle: Vehicle, size: float, seed: int) -> list[tuple[float, Vec3]]:
    """Demands around hover; size 1 reaches what the rotors can just do."""
    rng, mixer = np.random.default_rng(seed), np.abs(Quadrotor(vehicle).mixer)
    hover = vehicle.mass * vehicle.gravity / 4.0
    reach = mixer @ np.full(4, hover)
    rows = rng.uniform(-1.0, 1.0, (DEMANDS, 4)) * size * reach
    return [(4.0 * hover + row[0], Vec3(*row[1:].tolist())) for row in rows]


@pytest.mark.parametrize("name", VEHICLES)
def test_allocation_is_the_inverse_of_the_mixer(name: str) -> None:
    # T16. The condition number of the scaled mixer is a few hundred at most: 1e-12 is a thousand roundings.
    vehicle = VEHICLES[name]
    inverse = np.array(known(vehicle).allocation).T
    mixer = Quadrotor(vehicle).mixer
    scale = np.abs(mixer).max(axis=1)
    np.testing.assert_allclose((mixer / scale[:, None]) @ (inverse * scale), np.eye(4), rtol=0.0, atol=1e-12)


def test_allocation_of_an_x_frame_is_the_printed_inverse() -> None:
    """T_i = T/4 +- tx/(4a) +- ty/(4a) +- tz/(4c) with a = L/sqrt 2 and c = k_m/k_f."""
    assert HUMMINGBIRD.rotor_x.r1 == pytest.approx(0.171 / sqrt(2.0), rel=1e-15)
    a, c = 4.0 * 0.171 / sqrt(2.0), 4.0 * HUMMINGBIRD.torque_ratio
    found = known(HUMMINGBIRD).allocation
    np.testing.assert_allclose(found.thrust, [0.25, 0.25, 0.25, 0.25], rtol=1e-13)
    np.testing.assert_allclose(found.roll, [1 / a, -1 / a, 1 / a, -1 / a], rtol=1e-13)
    np.testing.assert_allclose(found.pitch, [-1 / a, -1 / a, 1 / a, 1 / a], rtol=1e-13)
    np.testing.assert_allclose(found.yaw, [1 / c, -1 / c, -1 / c, 1 / c], rtol=1e-13)


@pytest.mark.parametrize("name", VEHICLES)
def test_one_diagonal_up_and_the_other_down_is_pure_yaw(name: str) -> None:
    # T16: rotors 1 and 4 share a diagonal and a spin. With spin + - - + their reaction on the body is about +z.
    vehicle = VEHICLES[name]
    up, down = 1.1, 0.9
    torque = rotor_torque(
        Rotors(up, down, down, up), vehicle.rotor_x, vehicle.rotor_y, vehicle.spin, vehicle.torque_ratio
    )
    assert torque.z == pytest.approx(0.4 * vehicle.torque_ratio * vehicle.spin.r1, rel=1e-12)
    assert abs(torque.x) + abs(torque.y) < 1e-16
    assert vehicle.spin.r1 == vehicle.spin.r4 == -vehicle.spin.r2 == -vehicle.spin.r3


@pytest.mark.parametrize("name", VEHICLES)
def test_left_rotors_roll_right_and_front_rotors_lift_the_nose(name: str) -> None:
    """FLU: positive roll lowers the right side, positive pitch lowers the nose."""
    v = VEHICLES[name]
    more_left = Rotors(*[1.0 + 0.1 * np.sign(y) for y in v.rotor_y])
    more_front = Rotors(*[1.0 + 0.1 * np.sign(x) for x in v.rotor_x])
    assert rotor_torque(more_left, v.rotor_x, v.rotor_y, v.spin, v.torque_ratio).x > 0.0
    assert rotor_torque(more_front, v.rotor_x, v.rotor_y, v.spin, v.torque_ratio).y < 0.0


@pytest.mark.parametrize("name", VEHICLES)
def test_a_feasible_demand_is_met_exactly(name: str) -> None:
    vehicle = VEHICLES[name]
    know = known(vehicle)
    inverse = np.linalg.inv(Quadrotor(vehicle).mixer)
    met = 0
    for lift, torque in random_demands(vehicle, 0.3, seed=4):
        wanted = inverse @ [lift, *torque]
        if know.thrust_min <= wanted.min(axis=0) and wanted.max(axis=0) <= know.thrust_max:
            command = allocate(lift, torque, know)
            np.testing.assert_allclose(command, wanted, rtol=0.0, atol=1e-12 * know.thrust_max)
            met += 1
    assert met > DEMANDS // 10


@pytest.mark.parametrize("name", VEHICLES)
def test_yaw_is_dropped_first(name: str) -> None:
    # Where thrust, roll and pitch fit without yaw they are kept to rounding; of yaw as much is kept as fits: a rotor
    # stands at a limit.
    vehicle = VEHICLES[name]
    know = known(vehicle)
    inverse = np.linalg.inv(Quadrotor(vehicle).mixer)
    cut = 0
    for lift, torque in random_demands(vehicle, 0.7, seed=5):
        torque = torque._replace(z=5.0 * torque.z)
        base = inverse @ [lift, torque.x, torque.y, 0.0]
        full = inverse @ [lift, *torque]
        fits = know.thrust_min < base.min(axis=0) and base.max(axis=0) < know.thrust_max
        if fits and not (know.thrust_min <= full.min(axis=0) and full.max(axis=0) <= know.thrust_max):
            command = allocate(lift, torque, know)
            kept = wrench(vehicle, command)
            reach = np.abs(Quadrotor(vehicle).mixer).max(axis=1) * know.thrust_max
            np.testing.assert_allclose(
                kept[:3], [lift, torque.x, torque.y], rtol=0.0, atol=1e-12 * reach[:3].max(axis=0)
            )
            assert 0.0 <= kept[3] * np.sign(torque.z) < abs(torque.z)
            room = np.minimum(np.array(command) - know.thrust_min, know.thrust_max - np.array(command))
            assert room.min(axis=0) < 1e-12 * know.thrust_max
            cut += 1
    assert cut > DEMANDS // 10


@pytest.mark.parametrize("name", VEHICLES)
def test_no_yaw_is_given_that_would_push_a_rotor_further_out(name: str) -> None:
    """Where thrust, roll and pitch alone do not fit, they are clipped, and yaw is neither added nor reversed."""
    vehicle = VEHICLES[name]
    know = known(vehicle)
    low, high = know.thrust_min, know.thrust_max
    inverse = np.linalg.inv(Quadrotor(vehicle).mixer)
    unfit = 0
    for lift, torque in random_demands(vehicle, 3.0, seed=8):
        base, yaw = inverse @ [lift, torque.x, torque.y, 0.0], inverse[:, 3] * torque.z
        if (((base > high) & (yaw > 0.0)) | ((base < low) & (yaw < 0.0))).any(axis=0):
            command = allocate(lift, torque, know)
            np.testing.assert_allclose(command, np.clip(base, low, high), rtol=0.0, atol=1e-12 * high)
            unfit += 1
    assert unfit > DEMANDS // 10


@pytest.mark.parametrize("name", VEHICLES)
def test_limits_are_never_exceeded(name: str) -> None:
    vehicle = VEHICLES[name]
    know = known(vehicle)
    zero = Vec3(0.0, 0.0, 0.0)
    demands = [
        *random_demands(vehicle, 1.0, 6),
        *random_demands(vehicle, 100.0, 7),
        (0.0, zero),
        (-5.0, zero),
        (1e6, zero),
    ]
    for lift, torque in demands:
        command = allocate(lift, torque, know)
        assert min(command) >= know.thrust_min
        assert max(command) <= know.thrust_max


@pytest.mark.parametrize("name", VEHICLES)
def test_saturation_is_told_exactly_when_a_rotor_stands_at_a_limit(name: str) -> None:
    know = known(VEHICLES[name])
    middle = 0.5 * (know.thrust_min + know.thrust_max)
    assert saturated(Rotors(middle, middle, middle, middle), know) == 0.0
    for limit in (know.thrust_min, know.thrust_max):
        for rotor in ("r1", "r2", "r3", "r4"):
            assert saturated(Rotors(middle, middle, middle, middle)._replace(**{rotor: limit}), know) == 1.0


@pytest.mark.parametrize("name", VEHICLES)
def test_speed_commands_give_the_thrusts_asked_for(name: str) -> None:
    know = known(VEHICLES[name])
    asked = Rotors(know.thrust_min, know.hover, 1.3 * know.hover, know.thrust_max)
    speeds = speed_commands(asked, know)
    np.testing.assert_allclose(rotor_thrusts(speeds, know.vehicle.thrust_coefficient), asked, rtol=1e-14)
    assert max(speeds) == pytest.approx(know.vehicle.speed_max, rel=1e-14)


def test_modelled_lag_is_that_of_a_first_order_rotor() -> None:
    """After one period of a step exp(-h/tau) of it is missing, and on average over it (1 - exp(-h/tau)) tau/h."""
    know = nominal(HUMMINGBIRD._replace(lag_up=0.015, lag_down=0.025), ControlOptions(), 0.01)
    t = (np.arange(100_000) + 0.5) * 1e-7
    assert know.lag_step == pytest.approx(1.0 - np.exp(-0.5), rel=1e-12)
    assert know.lag_missing == pytest.approx(float(np.mean(np.exp(-t / 0.02), axis=0)), rel=1e-9)
    unaware = nominal(HUMMINGBIRD, ControlOptions(lag_aware=False), 0.01)
    assert (unaware.lag_step, unaware.lag_missing) == (1.0, 0.0)
