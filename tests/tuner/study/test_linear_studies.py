"""Studies of linear plants by their numbers: from keys of [plant] to what flies, digests, refusals, and C."""

import re
import subprocess
import tomllib
from typing import Any

import control
import pytest

from plant.errors import InputError
from tests.tuner.conftest import QUICKSTART
from tests.tuner.exchange.c99.test_plant_c99 import STRICT, compiled, written
from tuner.api.studies import load_study, make_study
from tuner.exchange.c99.export import plant_files
from tuner.store.advice import can_be_resumed
from tuner.study.plant_study import PlantStudy
from tuner.study.reading import parse_toml
from tuner.study.study import Study

HEATER = QUICKSTART.parent / "heater.toml"
TANKS = {"A": [[-0.5, 0.0], [0.5, -0.2]], "B": [[1.0, 0.0], [0.0, 0.3]], "C": [[1.0, 0.0], [0.0, 1.0]]}


def tables(**changes: Any) -> dict[str, Any]:
    """The heater's tables; a key of [plant] that is None is left out."""
    table: dict[str, Any] = parse_toml(HEATER)
    table["plant"] = {key: value for key, value in {**table["plant"], **changes}.items() if value is not None}
    return table


def test_dead_time_stands_behind_the_actuator_of_the_study_or_behind_none():
    study = load_study(HEATER, kind=PlantStudy)
    (heater,) = study.system.plan.actuators
    assert (heater.delay, heater.high, heater.periods(0.25)) == (2.0, 10.0, 8)
    bare = tables()
    bare["actuator"] = []
    bare["objective"] = bare["objective"][:1]
    (free,) = make_study(bare, "heater", kind=PlantStudy).system.plan.actuators
    assert (free.delay, free.bounded) == (2.0, False)
    late = tables()
    late["actuator"][0]["delay"] = 0.5
    assert make_study(late, "heater", kind=PlantStudy).system.plan.actuators[0].delay == 2.5


def test_every_number_counts_in_the_digest():
    changes = (
        {},
        {"transfer_function": {"numerator": [1.8000001], "denominator": [120.0, 23.0, 1.0]}},
        {"transfer_function": {"numerator": [1.8], "denominator": [120.0, 23.0, 1.1]}},
        {"dead_time": 2.25},
        {"dead_time": None},
        {"parameters": {"a0": 1.2}},
    )
    digests = [make_study(tables(**each), "heater").digest() for each in changes]
    assert len(set(digests)) == len(digests)
    assert digests[0] == load_study(HEATER, kind=PlantStudy).digest()


def test_a_study_of_another_class_than_is_wanted_is_refused():
    for make in (lambda kind: load_study(HEATER, kind=kind), lambda kind: make_study(tables(), "heater", kind=kind)):
        assert make(PlantStudy).flown == "heater"
        with pytest.raises(InputError, match="its class is PlantStudy, and kind = Study; leave kind out"):
            make(Study)


def test_a_system_of_python_control_makes_the_study_of_its_numbers():
    given = control.tf([1.8], [120.0, 23.0, 1.0])
    study = make_study(tables(transfer_function=None), "heater", plant=given)
    assert study.digest() == load_study(HEATER, kind=PlantStudy).digest() and study.is_resumable
    assert study.given is not None and tomllib.loads(study.given)["plant"]["transfer_function"]["numerator"] == [1.8]


@pytest.mark.parametrize(("plant", "resumed"), [('file = "motor.py"', False), ("", False), (None, True)])
def test_a_folder_is_resumed_where_the_study_itself_holds_the_plant(plant, resumed, tmp_path):
    """No file of code lies in such a folder, as in one of a notebook's plant, which cannot be resumed."""
    (tmp_path / "inputs").mkdir()
    text = HEATER.read_text() if plant is None else f"[plant]\n{plant}\n"
    (tmp_path / "inputs" / "study.toml").write_text(text)
    (tmp_path / "run.json").write_text('{"kind": "plant"}')
    assert can_be_resumed(tmp_path) is resumed


@pytest.mark.slow
def test_two_tanks_of_a_state_space_have_two_channels():
    table = tables(
        transfer_function=None,
        state_space=TANKS,
        inputs=["upper_valve", "lower_valve"],
        outputs=["upper", "lower"],
        units=None,
    )
    table["actuator"] = []
    channel = table["channel"][0]
    table["channel"] = [{**channel, "name": name, "output": name, "to": f"{name}_valve"} for name in ("upper", "lower")]
    table["gains"] = {f"{name}.{gain}": 0.5 for name in ("upper", "lower") for gain in ("kp", "ki", "kd", "t_f")}
    table["gains"] |= {"upper.kp": {"low": 0.1, "high": 2.0}}
    for scenario in table["scenario"]:
        scenario.update(
            disturbance={"upper_valve_load": {"kind": "step", "size": 1.0}}, sensors={}, spread={"b_2_2": 0.1}
        )
        scenario["reference"] = {"lower": {"kind": "step", "size": 1.0}}
    table["objective"] = [{"metric": "iae.lower"}]
    study = make_study(table, "tanks", kind=PlantStudy)
    assert [each.delay for each in study.system.plan.actuators] == [2.0, 2.0]
    assert study.system.plan.names == ("upper", "lower")


def test_its_controller_in_c_has_the_bits_of_its_golden_vectors(tmp_path):
    study = load_study(HEATER, kind=PlantStudy)
    written(tmp_path, plant_files(study.system, study.default_row.tolist(), real="float", name="heater"))
    compiled(tmp_path, "gcc", STRICT, "heater_controller.c", "test_golden.c", "-o", "golden")
    done = subprocess.run(["./golden"], cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "the same bits: 200 steps\n")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"dead_time": 2.1},
            "plant.dead_time: given 2.1 s; a delay must be a whole number of control periods of 0.25 s",
        ),
        ({"dead_time": -1.0}, "plant.dead_time: given -1.0 s; allowed: 0 s or more"),
        ({"dead_time": 400.0}, "plant.dead_time: given 400 s, 1600 control periods; allowed: up to 1024"),
        ({"file": "motor.py"}, "plant: needs a file or an FMU, one of them"),
        ({"state_space": TANKS}, "plant: needs a file or an FMU, one of them"),
        ({"patience": 3.0}, "plant.patience: belongs to an FMU"),
        ({"units": {"heat": "kW"}}, "plant.units.heat: unknown signal 'heat'; did you mean 'heater'?"),
        ({"parameters": {"b1": 1.0}}, "plant.parameters.b1: unknown parameter 'b1'"),
        ({"transfer_function": {"numerator": [1.0]}}, "plant.transfer_function.denominator"),
        (
            {"transfer_function": {"numerator": [float("nan")], "denominator": [1.0, 1.0]}},
            "plant.transfer_function.numerator[0]",
        ),
        (
            {"transfer_function": {"numerator": ["1"], "denominator": [1.0, 1.0]}},
            "plant.transfer_function.numerator[0]",
        ),
        (
            {"transfer_function": {"numerator": [1.0], "denominator": [0.0, 1.0]}},
            "plant.transfer_function.denominator: given",
        ),
        (
            {"transfer_function": None, "state_space": {**TANKS, "B": [[1.0]]}},
            "plant.state_space.B: must have 2 rows of 1 numbers",
        ),
    ],
)
def test_what_is_no_plant_is_refused_with_file_and_key(changes, message):
    with pytest.raises(InputError, match=re.escape(f"heater.toml: {message}")):
        make_study(tables(**changes), "heater")


def test_keys_of_linear_plants_belong_to_no_other():
    table: dict[str, Any] = parse_toml(QUICKSTART.parent / "dc_motor.toml")
    table["plant"]["dead_time"] = 0.001
    with pytest.raises(InputError, match="plant.dead_time: belongs to a linear plant given by numbers: leave it out"):
        make_study(table, "dc_motor", QUICKSTART.parent)
