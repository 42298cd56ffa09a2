"""The bundled airframes: their numbers against the published ones, their geometry, and what is derived from them."""

import re
from pathlib import Path

import numpy as np
import pytest

import plant.quadrotor.airframes
from plant.quadrotor.airframes import load, names
from plant.quadrotor.airframes.derived import quantities
from plant.quadrotor.airframes.geometry import FRAMES, SPINS
from plant.quadrotor.vehicle import Vehicle

README = Path(plant.quadrotor.airframes.__file__).with_name("README.md")

# Hover speed [rad/s], thrust to weight, as tabulated for the published sets (rounded to 1 rad/s and 0.01).
PUBLISHED = {
    "hummingbird": (496, 3.29),
    "hummingbird-rotors": (453, 3.42),
    "crazyflie-rotors": (2273, 1.33),
    "crazyflie-pybullet": (1516, 2.25),
    "f450": (557, 3.26),
    "iris": (805, 1.87),
    "racer5": (1086, 4.61),
}


def bundled(name: str) -> Vehicle:
    """Return the vehicle of a bundled file."""
    return load(name, allow_unphysical=True).vehicle


def allocation(vehicle: Vehicle) -> np.ndarray:
    """Return B (4, 4): thrust, roll, pitch, yaw torque of unit rotor thrusts, as sums of r x T and reaction torques."""
    arms = np.stack([vehicle.rotor_x, vehicle.rotor_y, np.zeros(4)], axis=1)
    torques = np.cross(arms, [0.0, 0.0, 1.0])
    torques[:, 2] += vehicle.torque_ratio * np.array(vehicle.spin)
    return np.vstack([np.ones(4), torques.T])


def test_names_are_the_files_that_the_readme_lists() -> None:
    """The README's table has one row per bundled file, and its numbers are those of the file to the digits shown."""
    rows = dict(re.findall(r"^\| `([\w-]+)` \| (.+?) \|$", README.read_text(), flags=re.MULTILINE))
    assert tuple(sorted(rows)) == names()
    for name, cells in rows.items():
        mass, hover, ratio, frame = cells.split(" | ")[:4]
        derived = quantities(bundled(name))
        assert f"{bundled(name).mass:g}" == f"{float(mass):g}"
        assert f"{derived['hover_speed'].value:.0f}" == hover
        assert f"{derived['thrust_to_weight'].value:.2f}" == ratio
        assert load(name, allow_unphysical=True).frame == frame


@pytest.mark.parametrize("name", names())
def test_every_bundled_file_loads(name: str) -> None:
    """All load, only the paper's literal table needs permission, and every number keeps its unit and source."""
    airframe = load(name, allow_unphysical=name == "paper-literal")
    assert airframe.name == name
    assert airframe.title
    assert len(airframe.sources) in (23, 24)  # 10 scalars, 4 vectors, one or two lengths
    assert airframe.sources["mass"].value == airframe.vehicle.mass
    assert airframe.sources["mass"].unit == "kg"


@pytest.mark.parametrize(("name", "published"), PUBLISHED.items())
def test_hover_speed_and_thrust_to_weight_as_published(name: str, published: tuple[float, float]) -> None:
    """Derived numbers agree with the published ones within their rounding (Iris: 1.865 from 805.5, tabulated 1.87)."""
    derived = quantities(bundled(name))
    assert derived["hover_speed"].value == pytest.approx(published[0], abs=0.5)
    assert derived["thrust_to_weight"].value == pytest.approx(published[1], abs=0.006)


def test_rotorpy_maximum_speed_was_lowered() -> None:
    """At its own 1500 rad/s the RotorPy set has 10.2, which no Hummingbird has; the bundled file has less than 5."""
    vehicle = bundled("hummingbird-rotorpy")
    as_published = quantities(vehicle._replace(speed_max=1500.0))
    assert as_published["hover_speed"].value == pytest.approx(469, abs=0.5)
    assert as_published["thrust_to_weight"].value == pytest.approx(10.2, abs=0.05)
    assert 1.2 < quantities(vehicle)["thrust_to_weight"].value < 5.0


def test_corrected_hummingbird_is_the_published_set() -> None:
    """The set of which the seed study's table is a shifted copy."""
    vehicle = bundled("hummingbird")
    assert vehicle.inertia == (0.0034, 0.0034, 0.0060)
    assert (vehicle.mass, vehicle.rotor_inertia) == (0.698, 1.302e-6)
    assert vehicle.speed_min == pytest.approx(110 * np.pi / 3, abs=0.05)
    assert vehicle.speed_max == pytest.approx(860 * np.pi / 3, abs=0.05)
    per_rpm = (60 / (2 * np.pi)) ** 2
    assert vehicle.thrust_coefficient == pytest.approx(7.6184e-8 * per_rpm, rel=1e-4)
    assert vehicle.torque_ratio * vehicle.thrust_coefficient == pytest.approx(2.6839e-9 * per_rpm, rel=2e-4)
    assert vehicle.lag_up == vehicle.lag_down == 0.02


def test_authority_of_the_hummingbird() -> None:
    """Without a lower speed limit: 0.83 N m (243 rad/s2) of roll and 0.24 N m (40 rad/s2) of yaw; with it, less."""
    vehicle = bundled("hummingbird")
    free = quantities(vehicle._replace(speed_min=0.0))
    assert free["roll_torque"].value == pytest.approx(0.83, abs=0.005)
    assert free["roll_acceleration"].value == pytest.approx(243, abs=1)
    assert free["yaw_torque"].value == pytest.approx(0.24, abs=0.005)
    assert free["yaw_acceleration"].value == pytest.approx(40, abs=0.5)
    assert quantities(vehicle)["roll_torque"].value < free["roll_torque"].value


@pytest.mark.parametrize("name", names())
def test_derived_torques_are_what_the_allocation_can_give(name: str) -> None:
    """Oracle: no corner of the thrust box at hover thrust gives more torque, and the derived one is reached."""
    vehicle = bundled(name)
    derived = quantities(vehicle)
    hover = derived["hover_thrust"].value
    low = vehicle.thrust_coefficient * vehicle.speed_min**2 - hover
    high = vehicle.thrust_coefficient * vehicle.speed_max**2 - hover
    swing = min(high, -low)
    signs = np.array(np.meshgrid(*[[-1.0, 0.0, 1.0]] * 4)).reshape(4, -1)
    balanced = signs[:, np.sum(signs, axis=0) == 0.0]
    best = np.max(allocation(vehicle) @ (swing * balanced), axis=1)
    assert derived["roll_torque"].value == pytest.approx(best[1])
    assert derived["pitch_torque"].value == pytest.approx(best[2])
    assert derived["yaw_torque"].value == pytest.approx(best[3])


def test_x_frame_allocation_is_the_textbook_one() -> None:
    """B times the printed inverse of the X mixer is the identity."""
    vehicle = bundled("hummingbird")
    a, c = 0.171 / np.sqrt(2.0), vehicle.torque_ratio
    signs = np.array([[1, 1, -1, 1], [1, -1, -1, -1], [1, 1, 1, -1], [1, -1, 1, 1]])
    inverse = signs / np.array([4, 4 * a, 4 * a, 4 * c])
    np.testing.assert_allclose(allocation(vehicle) @ inverse, np.eye(4), atol=1e-12)


@pytest.mark.parametrize("frame", FRAMES)
def test_every_frame_decouples_its_four_inputs(frame: str) -> None:
    """Rows of the allocation are orthogonal: no rotor pattern for one input disturbs another, at the centre of mass."""
    lengths = {"arm": 0.3, "lever_fore_aft": 0.13, "lever_side": 0.22}
    positions = FRAMES[frame].positions(lengths)
    vehicle = bundled("hummingbird")._replace(rotor_x=positions.x, rotor_y=positions.y)
    b = allocation(vehicle)
    gram = b @ b.T
    np.testing.assert_allclose(gram, np.diag(np.diag(gram)), atol=1e-12)


def test_plus_frame_is_the_x_frame_turned() -> None:
    """Turning the x frame by -45 degrees about z gives the plus frame rotor by rotor, with sqrt(2) less roll torque."""
    x, plus = FRAMES["x"].positions({"arm": 0.2}), FRAMES["plus"].positions({"arm": 0.2})
    turned = np.exp(-0.25j * np.pi) * (np.array(x.x) + 1j * np.array(x.y))
    np.testing.assert_allclose(turned, np.array(plus.x) + 1j * np.array(plus.y), atol=1e-15)
    vehicle = bundled("hummingbird")
    as_plus = quantities(vehicle._replace(rotor_x=plus.x, rotor_y=plus.y))["roll_torque"].value
    as_x = quantities(vehicle._replace(rotor_x=x.x, rotor_y=x.y))["roll_torque"].value
    assert as_x / as_plus == pytest.approx(np.sqrt(2.0))


def test_diagonal_rotors_turn_alike() -> None:
    """Whichever way rotor 1 turns, 4 turns alike and 2 and 3 the other way; the two spins are each other's mirror."""
    for spin in SPINS.values():
        assert spin.r1 == spin.r4 == -spin.r2 == -spin.r3
    assert SPINS["+--+"].r1 == -SPINS["-++-"].r1 == 1.0
