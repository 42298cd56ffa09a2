"""The FMU of a plant's controller: FMPy finds nothing wrong and gets the commands of our own functions, to the bit."""

import io
import json
import xml.etree.ElementTree as ET
import zipfile

import pytest

import tuner
from plant.backends.c_code import REALS
from plant.records import flatten
from tests.clients import ask
from tests.tuner.conftest import QUICKSTART
from tests.tuner.extensions.design_rules.test_state_observer import mass_study
from tests.tuner.extensions.fmi.fmus import HEAD
from tuner.exchange.c99.plant import plant_flight, tuned_plant
from tuner.exchange.target import PlantRequest
from tuner.extensions.fmi.plant_export import plant_fmu
from tuner.study.plant_controller import PlantController
from tuner.study.plant_study import PlantStudy

STEPS = 300


def request(name, real="double"):
    if name == "sensorless":
        study = mass_study({"noise": {"place": 1e-3}, "input_noise": {"u": 1.0}})
    else:
        study = tuner.load_study(QUICKSTART.with_name(f"{name}.toml"), kind=PlantStudy)
    return PlantRequest(PlantController(study, tuple(study.default_row)), "0" * 64, {"real": real})


def numbers(records):
    """The numbers of records of signals, as a list."""
    return [float(value[0] if hasattr(value, "__len__") else value) for record in records for value in flatten(record)]


@pytest.mark.parametrize("name", ["dc_motor", "two_masses", "sensorless"])
def test_fmpy_gets_the_commands_of_our_own_functions(name, tmp_path):
    """dc_motor has a delayed input, two_masses a law with an observer, the last study no sensor of the speed that it feeds back."""
    asked = request(name)
    tuned = tuned_plant(asked.controller.study.system, asked.controller.gains)
    (begun, *_), *flown = plant_flight(tuned, REALS["double"], STEPS)
    rows = [numbers(inputs) for inputs, *_ in flown]
    expected = [[value.hex() for value in numbers(command)] for _, command, _ in flown]
    path, inputs = tmp_path / "a.fmu", tmp_path / "inputs.json"
    path.write_bytes(plant_fmu(asked)[0])
    first = [*rows[0][: -len(numbers(begun[:1]))], *numbers(begun[:1])]
    inputs.write_text(json.dumps([first, *rows]))
    run = """
from fmpy.validation import validate_fmu
one = instance("a"); begin(one, rows[0])
print(json.dumps([validate_fmu(sys.argv[1]), [step(one, k, row) for k, row in enumerate(rows[1:])]]))
"""
    problems, found = ask("fmi", HEAD + run, str(path), str(inputs))
    assert problems == [] and found == expected
    assert len({tuple(row) for row in expected}) > 0.2 * STEPS


def test_its_variables_have_the_units_of_the_plant_and_start_at_rest():
    mock_up, values, code = plant_fmu(request("heater", "float"))
    with zipfile.ZipFile(io.BytesIO(mock_up)) as held:
        root = ET.fromstring(held.read("modelDescription.xml"))
    found = {each.get("name"): (each.get("causality"), each[0].get("unit")) for each in root.iter("ScalarVariable")}
    assert found["measured.temperature"] == ("input", "K") and found["command.heater"] == ("output", "kW")
    assert found["reference.temperature.rate"] == ("input", "K/s")
    units = {each.get("name"): len(each) for each in root.iter("Unit")}
    assert units["s"] == 1 and units["kW"] == 0
    assert code.guid == root.get("guid") and b'name="gains.temperature.kp"' in values
