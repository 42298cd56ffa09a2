"""The FMU in FMPy, a simulator nobody here wrote: valid, and bit for bit the C99 code that it is made of."""

import pytest

from tests.clients import ask, program
from tests.tuner.extensions.fmi.fmus import HEAD, c_outputs, flight, request, write_inputs
from tuner.extensions.fmi.export import fmu


@pytest.fixture(scope="module")
def mock_up(tmp_path_factory):
    """An FMU of the hybrid in single precision, with the inputs of a flight."""
    program("gcc")
    folder, asked = tmp_path_factory.mktemp("fmu"), request()
    path = folder / "gainproof.fmu"
    path.write_bytes(fmu(asked)[0])
    rows = flight(asked.controller)
    return path, write_inputs(folder / "inputs.json", rows), rows, asked.controller


def test_fmpy_finds_nothing_wrong_and_flies_a_thousand_steps_at_the_period_of_the_controller(mock_up):
    script = """
import json, sys
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu
found = simulate_fmu(sys.argv[1], stop_time=2.0, validate=True)
print(json.dumps({"problems": validate_fmu(sys.argv[1]), "steps": len(found) - 1, "names": found.dtype.names,
                  "first": found[0].tolist(), "last": found[-1].tolist()}))
"""
    said = ask("fmi", script, mock_up[0])
    assert said["problems"] == []
    assert said["steps"] == 1000
    assert said["names"][1:] == [
        *[f"rotor_thrust[{i}]" for i in range(1, 5)],
        "thrust",
        *[f"torque.{a}" for a in "xyz"],
    ]
    # The start values are hover at the origin, which is asked for: each rotor bears a quarter of 0.698 kg x 9.81 m/s2.
    for moment in (said["first"], said["last"]):
        assert moment[1:6] == pytest.approx([0.698 * 9.81 / 4] * 4 + [0.698 * 9.81], rel=1e-6)


@pytest.mark.parametrize(
    ("real", "attitude"), [("float", "hybrid"), pytest.param("double", "adrc", marks=pytest.mark.slow)]
)
def test_outputs_are_those_of_the_c_code_to_the_last_bit(real, attitude, tmp_path):
    asked = request(real, attitude=attitude)
    (tmp_path / "a.fmu").write_bytes(fmu(asked)[0])
    rows = flight(asked.controller)
    expected = c_outputs(asked.controller, rows, real, tmp_path)
    inputs = write_inputs(tmp_path / "inputs.json", rows)
    run = "\none = instance('a'); begin(one, rows[0])\nprint(json.dumps([step(one, k, row) for k, row in enumerate(rows)]))"
    assert ask("fmi", HEAD + run, str(tmp_path / "a.fmu"), str(inputs)) == expected
    assert len({tuple(row) for row in expected}) > 900  # so equality has something to say


def test_with_delay_the_command_comes_a_period_earlier_since_the_simulation_waits_itself(tmp_path):
    asked = request("double", delay=True)
    (tmp_path / "a.fmu").write_bytes(fmu(asked)[0])
    rows = flight(asked.controller)
    expected = c_outputs(asked.controller, rows, "double", tmp_path)
    inputs = write_inputs(tmp_path / "inputs.json", rows)
    run = "\none = instance('a'); begin(one, rows[0])\nprint(json.dumps([step(one, k, row) for k, row in enumerate(rows)]))"
    assert ask("fmi", HEAD + run, str(tmp_path / "a.fmu"), str(inputs))[:-1] == expected[1:]


def test_instances_are_apart_and_a_reset_or_a_restored_state_goes_on_as_before(mock_up):
    run = """
a, b = instance("a"), instance("b")
begin(a, rows[0]); begin(b, rows[100], start=5.0)
alone = [step(a, k, rows[k]) for k in range(100)]
a.reset(); begin(a, rows[0])
beside = []
for k in range(100):
    beside.append(step(a, k, rows[k]))
    step(b, k, rows[100 + k], start=5.0)
saved = a.getFMUstate()
bytes_of_it = a.serializeFMUstate(saved)
on = [step(a, k, rows[k]) for k in range(100, 120)]
a.setFMUstate(saved)
again = [step(a, k, rows[k]) for k in range(100, 120)]
restored = b.deSerializeFMUstate(bytes_of_it)
b.setFMUstate(restored)
elsewhere = [step(b, k, rows[k]) for k in range(100, 120)]
a.freeFMUstate(saved); b.freeFMUstate(restored)
for one in (a, b):
    one.terminate(); one.freeInstance()
print(json.dumps([alone == beside, on == again, on == elsewhere, alone[0] == alone[1]]))
"""
    assert ask("fmi", HEAD + run, mock_up[0], mock_up[1]) == [True, True, True, False]


def test_what_a_simulator_must_not_do_is_refused(mock_up):
    run = """
one = instance("one")
nan, inf = float("nan"), float("inf")
said = {"early step": refused(one.doStep, 0.0, period)}
begin(one, rows[0])
one.setReal(inputs, rows[0])
for name, size in (("half", 0.5 * period), ("none", 0.0), ("odd", 1.5 * period), ("back", -period), ("nan", nan), ("huge", 1e300)):
    said[name] = refused(one.doStep, 0.0, size)
said["wrong time"] = refused(one.doStep, 0.1, period)
said["output set"] = refused(one.setReal, outputs[:1], [1.0])
gain = next(v for v in about.modelVariables if v.name == "gains.roll.k1")
said["gain set"] = refused(one.setReal, [gain.valueReference], [1.0])
said["no such variable"] = refused(one.getReal, [10000])
said["wrong guid"] = refused(instance, "two", "{00000000-0000-0000-0000-000000000000}")
fine = {"rounded": refused(one.doStep, 0.0, period * (1.0 + 1e-9)), "three": refused(one.doStep, period, 3.0 * period)}
value = one.getReal([gain.valueReference])[0]
one.setReal(inputs[:1], [nan])
said["nan"] = refused(one.doStep, 4.0 * period, period)
print(json.dumps([said, fine, value]))
"""
    said, fine, value = ask("fmi", HEAD + run, mock_up[0], mock_up[1])
    assert all(said.values()), said
    assert not any(fine.values()), fine
    assert value == 20.0


def test_a_step_of_three_periods_is_three_steps_with_the_inputs_held(mock_up):
    run = """
a, b = instance("a"), instance("b")
begin(a, rows[0]); begin(b, rows[0])
for k in range(3):
    last = step(a, k, rows[50])
b.setReal(inputs, rows[50]); b.doStep(0.0, 3 * period)
print(json.dumps([last, [value.hex() for value in b.getReal(outputs)], step(a, 3, rows[51]) == step(b, 3, rows[51])]))
"""
    first, second, go_on = ask("fmi", HEAD + run, mock_up[0], mock_up[1])
    assert first == second and go_on
