"""The sanity rules: what they must refuse, that each of them can fire, and who may overrule them."""

from math import pi, sqrt
from pathlib import Path

import pytest

from plant.errors import UnphysicalError
from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.rules import RULES, broken_rules
from plant.quadrotor.vehicle import Vehicle
from plant.vectors import Vec3

GOOD = load("hummingbird").vehicle

# What is wrong, and the opening of the one sentence that says so.
MUTATIONS = {
    "z beyond x + y": ({"inertia": Vec3(0.0034, 0.0034, 0.0069)}, "triangle inequality: Iz"),
    "x beyond y + z": ({"inertia": Vec3(0.0100, 0.0010, 0.0070)}, "triangle inequality: Ix"),
    "a sphere": ({"inertia": Vec3(0.0034, 0.0034, 0.0034)}, "yaw inertia"),
    "too strong": ({"speed_max": 2100.0}, "thrust to weight"),
    "torque coefficient for its ratio": ({"torque_ratio": 2.447e-7}, "torque ratio"),
    "torque ratio in cm": ({"torque_ratio": 3.5}, "torque ratio"),
    "hovers near its limit": ({"speed_max": 549.0}, "hover speed"),
    "cannot throttle down to hover": ({"speed_min": 500.0}, "hover speed"),
    "lag up in ms": ({"lag_up": 20.0}, "motor lag"),
    "no lag down": ({"lag_down": 0.001}, "motor lag"),
    "massless": ({"mass": 0.0}, "must be positive and finite: mass"),
    "inertia unknown": ({"inertia": Vec3(0.0034, float("nan"), 0.006)}, "must be positive and finite: inertia.y"),
    "boundless": ({"speed_max": float("inf")}, "must be positive and finite: speed_max"),
}


@pytest.mark.parametrize(("change", "opening"), MUTATIONS.values(), ids=MUTATIONS.keys())
def test_one_wrong_number_breaks_one_rule(change: dict[str, object], opening: str) -> None:
    """Each mutation of a good vehicle is refused by exactly the rule meant for it."""
    sentences = broken_rules(GOOD._replace(**change))
    assert len(sentences) == 1
    assert sentences[0].startswith(opening)


@pytest.mark.parametrize("diameter", [0.031, 0.127, 0.457])
def test_torque_ratios_go_with_the_propeller(diameter: float) -> None:
    """Figures of merit of 0.2 to 0.65 at C_T = 0.1 are propellers; one of 15 times the ideal ratio, or a fifth of it, is none."""
    ideal = sqrt(0.1 / (2.0 * pi**3)) * diameter
    rotor = GOOD._replace(thrust_coefficient=0.1 * 1.225 * diameter**4 / (4.0 * pi**2))
    for merit in (0.2, 0.65):
        assert not any("torque" in text for text in broken_rules(rotor._replace(torque_ratio=ideal / merit)))
    for wrong in (10.0 * ideal / 0.65, 0.2 * ideal):
        assert any("torque ratio" in text for text in broken_rules(rotor._replace(torque_ratio=wrong)))


def test_every_rule_is_needed() -> None:
    """Taking any rule away would let one of the mutations through."""
    changes = [change for change, _ in MUTATIONS.values() if "mass" not in change]  # no rule can divide by a mass of 0
    fired = [{rule for rule in RULES if rule(GOOD._replace(**change))} for change in changes]
    assert set().union(*(rules for rules in fired if len(rules) == 1)) == set(RULES)


def test_weak_vehicles_break_two_rules() -> None:
    """Thrust to weight below 1.2 also hovers above 0.9 of the maximum speed (1 / 0.9^2 = 1.23): both are named."""
    sentences = broken_rules(GOOD._replace(speed_max=530.0))
    assert [sentence.split(":")[0] for sentence in sentences] == ["thrust to weight", "hover speed"]


def test_bounds_themselves_are_allowed() -> None:
    """A lamina (Iz = Ix + Iy exactly, in floating point 0.1 + 0.2 > 0.3 or not) and lags of 5 and 200 ms are real."""
    lamina = GOOD._replace(inertia=Vec3(0.1, 0.2, 0.1 + 0.2), lag_up=0.005, lag_down=0.200)
    assert broken_rules(lamina) == ()


@pytest.mark.parametrize(
    ("inertia", "accepted"),
    [((0.0034, 0.0060, 1.302e-6), False), ((0.0034, 0.0060, 1.302e-2), False), ((0.0034, 0.0034, 0.0060), True)],
)
@pytest.mark.parametrize("gravity", [9.8, 9.81])
def test_inertias_of_the_seed_study(inertia: tuple[float, float, float], accepted: bool, gravity: float) -> None:
    """Both readings of the printed table are refused by the triangle inequality; the corrected set is accepted."""
    sentences = broken_rules(GOOD._replace(inertia=Vec3(*inertia), gravity=gravity))
    assert (sentences == ()) is accepted
    assert any(sentence.startswith("triangle inequality") for sentence in sentences) is not accepted


def test_literal_paper_needs_permission_from_the_caller() -> None:
    """The file permits it; without the caller every broken rule is listed with its numbers and what to do."""
    with pytest.raises(UnphysicalError) as caught:
        load("paper-literal")
    message = str(caught.value)
    assert "paper-literal.toml" in message
    assert "Iy = 0.006 exceeds Ix + Iz = 0.0034013" in message
    assert "yaw inertia" in message
    assert "allow_unphysical = true" in message
    vehicle: Vehicle = load("paper-literal", allow_unphysical=True).vehicle
    assert vehicle.inertia == (0.0034, 0.0060, 1.302e-6)


@pytest.mark.parametrize("in_file", [False, True])
@pytest.mark.parametrize("by_caller", [False, True])
def test_permission_takes_two(tmp_path: Path, in_file: bool, by_caller: bool) -> None:
    """Only file and caller together overrule the rules."""
    text = Path(load("hummingbird").path).read_text().replace("value = 0.0060", "value = 0.0160")
    flag = f"allow_unphysical = {'true' if in_file else 'false'}\n"
    path = tmp_path / "heavy.toml"
    path.write_text(flag + text)
    if in_file and by_caller:
        assert load(path, allow_unphysical=True).vehicle.inertia.z == 0.0160
        return
    with pytest.raises(UnphysicalError, match="triangle inequality: Iz = 0.016") as caught:
        load(path, allow_unphysical=by_caller)
    remedy = str(caught.value).partition("allow_unphysical = true")[2]
    assert "in [airframe] of" in remedy
    assert "top of the file" in remedy or "at its top" in remedy


def test_racing_quadrotors_are_real() -> None:
    """0.55 kg under four motors of 1.75 kgf: 12.7 times the weight."""
    speed = sqrt(1.75 * 9.81 / 1.562522e-6)
    assert not broken_rules(load("racer5").vehicle._replace(mass=0.55, speed_max=speed))


def test_permission_is_not_needed_for_good_numbers() -> None:
    """Allowing what is not wrong changes nothing."""
    assert load("hummingbird", allow_unphysical=True) == load("hummingbird")
