"""What controllers cost: the packaged table against counts made here, and the inputs that they are counted on."""

import json
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from plant.errors import InputError
from plant.law_registry import LAWS
from plant.records import flatten
from plant.vectors import Vec3
from tests.clients import program
from tests.tuner.extensions.fmi.fmus import c_outputs
from tests.tuner.in_process import tuner
from tuner.exchange.c99.entries import AttitudeApplied, AttitudeMeasurement, AttitudeSetpoint, entries
from tuner.exchange.c99.quadrotor import c_sources, constants_of, nominal_of
from tuner.extensions.processor_cost import qemu
from tuner.extensions.processor_cost.cost import ProcessorCost, read_table, tabled
from tuner.extensions.processor_cost.inputs import attitude_row, step_row, typical_inputs
from tuner.extensions.processor_cost.measure import default_controller, measure_cost, measuring_program, table_text

# Another compiler may spend this share of instructions more or less.
OTHER_COMPILER = 0.1


@pytest.mark.parametrize(("position", "attitude"), [("ladrc", "hybrid"), ("pid", "pid"), ("adrc", "hybrid_gsta")])
def test_the_table_holds_what_is_counted_here(position, attitude):
    program("arm-none-eabi-gcc")
    program("qemu-system-arm")
    kept, now = tabled(position, attitude), measure_cost(default_controller(position, attitude))
    assert kept is not None
    if (kept.compiler, kept.emulator) == qemu.versions():
        assert now == kept
    else:
        assert now.instructions_step == pytest.approx(kept.instructions_step, rel=OTHER_COMPILER)
        assert now.instructions_attitude == pytest.approx(kept.instructions_attitude, rel=OTHER_COMPILER)
        assert now.state_bytes == kept.state_bytes


def test_the_table_has_every_pair_of_laws_and_its_numbers_make_sense():
    for position, attitude in product(LAWS, LAWS):
        cost = tabled(position, attitude)
        assert cost is not None, (position, attitude)
        assert 3 * 25 < cost.instructions_attitude <= cost.most_attitude < cost.instructions_step <= cost.most_step
        # The loops of position, the mixer and limits are the same whatever the attitude law.
        assert cost.instructions_step - cost.instructions_attitude > 250
        # A Smith predictor keeps 64 numbers in each of its loops.
        lines = 3 * 4 * 64 * [position, attitude].count("smith")
        assert 1000 < cost.text_bytes < 20_000 and 0 < cost.stack_bytes < 1000 + 3 * lines
        # Six loops keep a state of at least one float each; a state of the whole has the rotors' besides.
        assert 4 * (6 + 8) < cost.state_bytes < 1000 + lines and cost.state_bytes % 4 == 0
    assert tabled("pid", "of tomorrow") is None


def test_a_table_reads_back_as_it_was_written():
    costs = {name: {law: tabled(name, law) for law in ("pid", "adrc")} for name in ("ladrc", "pid")}
    assert {(p, a): cost for p, row in costs.items() for a, cost in row.items()} == read_table(table_text(costs))  # pyright: ignore[reportArgumentType]
    cost = costs["pid"]["pid"]
    assert cost is not None and ProcessorCost(**vars(cost)) == cost
    assert cost.per_second(0.002) == cost.instructions_step * 500.0


@pytest.mark.parametrize("attitude", ["adrc", "hybrid"])
def test_inputs_are_those_of_a_closed_flight(attitude):
    """Replayed, the cascade gives torques whose excess is what the attitude loops are told a period later."""
    own = default_controller("ladrc", attitude)
    instants = typical_inputs(own)
    assert len(instants) == 500
    bound, constants, knowledge = entries(own.cascade), constants_of(own), nominal_of(own)
    first = instants[0].measurement
    whole = bound.init(constants, knowledge, first)
    inner = bound.attitude_init(constants, first)
    worst, lean = 0.0, 0.0
    for now, then in zip(instants, instants[1:], strict=False):
        command, whole = bound.step(whole, constants, knowledge, now.reference, now.measurement, 0.004)
        effect, excess = (Vec3(*[getattr(one, name) for one in now.applied]) for name in ("effect", "excess"))
        setpoint = AttitudeSetpoint(*now.goal, now.reference.yaw_rate)
        seen = AttitudeMeasurement(Vec3(*now.angles), now.measurement.rate)
        told = AttitudeApplied(effect, excess)
        torque, inner = bound.attitude_step(inner, constants, knowledge, setpoint, seen, told, 0.004)
        for asked, made, slip in zip(flatten(torque), flatten(command.torque), then.applied, strict=True):
            worst = max(worst, abs(asked + slip.excess - made))
        lean = max(lean, abs(now.measurement.angles.x))
    assert worst < 1e-12
    assert 0.1 < lean < 0.7  # it leans into its steps, and stays away from the limit


def test_the_program_that_is_counted_computes_what_this_machine_does(tmp_path):
    program("arm-none-eabi-gcc")
    program("qemu-system-arm")
    own = default_controller("ladrc", "hybrid")
    instants, code = typical_inputs(own), c_sources(own, "float", "gainproof")
    main = measuring_program(instants, f"{code.name}.h", "gainproof", "float")
    sources = {f"{code.name}.h": code.header, f"{code.name}.c": code.source, "main.c": main}
    said = qemu.run_elf(qemu.build(sources, tmp_path)).splitlines()[-1]
    (tmp_path / "host").mkdir()
    thrust = c_outputs(own, [list(map(float, step_row(one))) for one in instants], "float", tmp_path / "host")[-1][4]
    assert float(said.split()[0]) == pytest.approx(float.fromhex(thrust), rel=1e-8)
    # The attitude loops alone, in double precision: their state has forgotten its single-precision rounding.
    bound, constants, knowledge = entries(own.cascade), constants_of(own), nominal_of(own)
    inner, torque = bound.attitude_init(constants, instants[0].measurement), None
    for now in instants:
        row = attitude_row(now)
        parts = [Vec3(*row[i : i + 3]) for i in (4, 7, 10, 13)]
        seen, told = AttitudeMeasurement(*parts[:2]), AttitudeApplied(*parts[2:])
        setpoint = AttitudeSetpoint(*now.goal, now.reference.yaw_rate)
        torque, inner = bound.attitude_step(inner, constants, knowledge, setpoint, seen, told, 0.004)
    np.testing.assert_allclose(list(map(float, said.split()[1:])), list(torque or ()), rtol=1e-4, atol=1e-6)


def test_a_flight_that_leaves_its_limits_is_counted_until_there():
    own = default_controller("ladrc", "pid")
    wild = replace(own, gains=tuple(-5.0 * gain for gain in own.gains))
    assert 1 <= len(typical_inputs(wild)) < 500


def test_command(monkeypatch, capsys):
    def run(*arguments):
        return tuner(monkeypatch, capsys, *arguments)

    code, said, _ = run("cost", "--json")
    rows = json.loads(said)["costs"]
    assert code == 0 and [row["attitude"] for row in rows] == list(LAWS)
    hybrid = next(row for row in rows if row["attitude"] == "hybrid")
    assert (
        hybrid["instructions_per_second"] == pytest.approx(250.0 * hybrid["instructions_step"])
        and not hybrid["measured"]
    )
    code, said, _ = run("cost", "--law", "hybrid", "--position-law", "pid")
    cost = tabled("pid", "hybrid")
    assert code == 0 and cost is not None and f"{cost.instructions_step:.0f}, {cost.most_step}" in said
    code, _, said = run("cost", "nothing.json", "--law", "hybrid")
    assert code == 2 and "give either a gains.json or --law NAME" in said
    code, _, said = run("cost", "--law", "hibrid")
    assert code == 2 and "did you mean 'hybrid'" in said


def test_measuring_without_the_toolchain_is_refused_with_the_remedy(monkeypatch):
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(InputError, match="apt-get install gcc-arm-none-eabi"):
        measure_cost(default_controller("ladrc", "pid"))
