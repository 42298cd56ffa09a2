"""Whole cascades: rows, ranges, fall-backs and authority."""

from dataclasses import replace

import numpy as np
import pytest

from objectives.design import DESIGNERS, DesignRequirements, design, design_axes
from objectives.design.cascade_design import authority
from plant.errors import InputError
from plant.law_registry import LAWS
from plant.quadrotor.allocation import allocate, saturated
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.gains import default_row, gain_addresses
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.vehicle import Vehicle
from plant.vectors import Rotors, Vec3
from tests.objectives.design.designed import HUMMINGBIRD, NAMES, TIMING, H, designs, known, row_of


@pytest.mark.parametrize("law", NAMES)
def test_gains_lie_in_their_ranges(law: str) -> None:
    cascade = close_cascade(LAWS[law], LAWS[law])
    row = row_of(cascade, designs(law))
    for gain in gain_addresses(cascade):
        span = gain.info.span(gain.loop)
        assert span.low <= row[gain.column] <= span.high, gain.address
        assert not gain.info.observer or row[gain.column] * H <= 0.3 * (1 + 1e-9)


def test_a_row_is_the_designs_in_their_columns() -> None:
    cascade = close_cascade(LAWS["pid"], LAWS["pid"])
    row = design(cascade, known(), TIMING)
    assert row.shape == (len(default_row(cascade)),)
    np.testing.assert_array_equal(row, row_of(cascade, designs("pid")))


def test_what_is_left_at_the_defaults() -> None:
    """No designer for the attitude law: it keeps its defaults, and so do x and y, which act through it; z does not."""
    cascade = close_cascade(LAWS["pid"], LAWS["adrc"])
    found = design_axes(cascade, known(), TIMING)
    assert LAWS["adrc"].family not in DESIGNERS
    for axis in ("roll", "pitch", "yaw", "x", "y"):
        law = cascade.attitude if axis in ("roll", "pitch", "yaw") else cascade.position
        assert not found[axis].designed and found[axis].why
        assert found[axis].gains._asdict() == law.defaults("attitude" if law is cascade.attitude else "position")
    assert found["z"].designed and found["z"].gains == designs("pid")["z"].gains


def test_position_law_without_designer() -> None:
    found = design_axes(close_cascade(LAWS["adrc"], LAWS["pid"]), known(), TIMING)
    assert [axis for axis in found if found[axis].designed] == ["roll", "pitch", "yaw"]


def test_a_slower_attitude_makes_a_slower_position() -> None:
    """Same cascade on rotors half as slow again."""
    slow = HUMMINGBIRD._replace(lag_up=1.5 * HUMMINGBIRD.lag_up, lag_down=1.5 * HUMMINGBIRD.lag_down)
    cascade = close_cascade(LAWS["pid"], LAWS["pid"])
    found = design_axes(cascade, nominal(slow, ControlOptions(delay=True), H), TIMING)
    for axis in ("roll", "x"):
        assert found[axis].designed
        assert found[axis].load_rejection < 0.6 * designs("pid")[axis].load_rejection


def test_a_dead_time_of_the_rotors_makes_a_slower_attitude() -> None:
    """As much as the computing delay of one period more makes it."""
    cascade = close_cascade(LAWS["pid"], LAWS["pid"])
    late = design_axes(cascade, nominal(HUMMINGBIRD._replace(dead_time=H), ControlOptions(delay=True), H), TIMING)[
        "roll"
    ]
    assert late.designed
    assert late.load_rejection < 0.9 * designs("pid")["roll"].load_rejection


# Front rotors further out than rear ones: their shares of a torque differ.
UNEVEN = HUMMINGBIRD._replace(
    rotor_y=Rotors(*(y * share for y, share in zip(HUMMINGBIRD.rotor_y, (1.3, 1.3, 0.8, 0.8), strict=True)))
)


@pytest.mark.parametrize("airframe", [HUMMINGBIRD, UNEVEN], ids=["even", "uneven"])
@pytest.mark.parametrize("axis", ["roll", "pitch", "yaw", "z"])
def test_authority_is_what_the_rotors_can_do_at_hover(axis: str, airframe: Vehicle) -> None:
    """A little less passes the allocation unclipped, a little more does not; also where the rotors' arms differ."""
    know = nominal(airframe, ControlOptions(delay=True), H)
    vehicle = know.vehicle
    most, weight = authority(know, axis), vehicle.mass * vehicle.gravity
    for share, clipped in ((0.999, 0.0), (1.001, 1.0)):
        torque = {
            "roll": Vec3(share * most * vehicle.inertia.x, 0.0, 0.0),
            "pitch": Vec3(0.0, share * most * vehicle.inertia.y, 0.0),
        }
        torque["yaw"] = Vec3(0.0, 0.0, share * most * vehicle.inertia.z)
        if axis == "z":
            # Upwards the rotors can do more than gravity allows downwards.
            assert most == pytest.approx(min(0.8 * vehicle.gravity, 4 * (know.hover - know.thrust_min) / vehicle.mass))
        else:
            assert saturated(allocate(weight, torque[axis], know), know) == clipped
    assert authority(know, "x") == pytest.approx(vehicle.gravity * np.tan(0.5236))


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("ms", 1.0),
        ("mt", np.inf),
        ("noise", 0.0),
        ("damping", -1.0),
        ("power_share", 1.0),
        ("speed", -0.1),
        ("position_step", 0.0),
    ],
)
def test_requirements_are_checked(key: str, value: float) -> None:
    with pytest.raises(InputError) as error:
        replace(DesignRequirements(), **{key: value})
    assert error.value.key == key


def test_other_requirements_give_other_designs_of_the_same_axes():
    cascade = close_cascade(LAWS["pid"], LAWS["pid"])
    usual = design_axes(cascade, known(), TIMING)["roll"]
    strict = design_axes(cascade, known(), TIMING, DesignRequirements(ms=1.4))["roll"]
    assert strict.ms < 1.42 < usual.ms
