"""What the contract says of plants is what a study that names them says."""

import pytest

from plant.contract.plant_contract import violations_of_plant
from plant.own_code import run_own_code
from tests.plant.model.plants import FILES

RATE = "torque = p.constant * current - p.friction * state.speed + disturbance.torque"


# Of each second of theirs most is compiling; the others are checked by .ci/run, and fly in tests of their own.
QUICK = ("modal",)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in FILES]
)
def test_plants_that_fly_keep_it(name):
    assert violations_of_plant(run_own_code(FILES[name]).names, name, str(FILES[name])) == []


@pytest.mark.parametrize("root", ["sqrt(input.voltage)", "sqrt(0.1 - state.angle) * sqrt(0.1 + state.angle)"])
def test_equations_without_a_value_off_their_domain_keep_it(root, tmp_path):
    """A study takes them: a root below 0 has no value, and a flight that meets it ends there."""
    motor = FILES["dc_motor"].read_text(encoding="utf-8")
    assert motor.count(RATE) == 1
    motor = motor.replace("from typing", "from plant.primitives import sqrt\nfrom typing", 1)
    file = tmp_path / "motor.py"
    file.write_text(motor.replace(RATE, f"{RATE} + 0.1 * ({root}) - 0.1 * ({root})"), encoding="utf-8")
    assert violations_of_plant(run_own_code(file).names, "motor", str(file)) == []


def test_an_equation_that_remembers_breaks_it(tmp_path):
    text = FILES["dc_motor"].read_text(encoding="utf-8").replace(RATE, f"LAST.append(1.0)\n    {RATE}")
    file = tmp_path / "motor.py"
    file.write_text(text.replace("class State", "LAST = []\n\n\nclass State"), encoding="utf-8")
    assert "hides between calls" in violations_of_plant(run_own_code(file).names, "motor", str(file))[0].message
