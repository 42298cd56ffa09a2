"""C of plants of one's own: the bits of Python's flights with noise, warnings as errors, golden vectors, units, refusals."""

import ctypes
import re
import subprocess
import sys
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Annotated, NamedTuple

import numpy as np
import pytest

from plant.backends.stepping import fly_steps, lane_of, unchanged
from plant.errors import InputError, StoreError, UnknownNameError
from plant.model.scenario import PlantScenario, SensorNoise
from plant.model.signals import Step
from plant.records import flatten, pack, size
from tests.clients import program
from tuner.api.plants import LAWS, Actuator, Channel, export_plant, plant_system
from tuner.exchange.c99.export import plant_files
from tuner.exchange.c99.plant import tuned_plant

EXAMPLE = Path(__file__).with_name("dc_motor.py")
FLAGS = ("-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O2", "-ffp-contract=off")
STRICT = (*FLAGS, "-Wconversion", "-Wdouble-promotion", "-Wshadow")
STEPS = 300


class State(NamedTuple):
    angle: Annotated[float, "rad"]
    speed: Annotated[float, "rad/s"]


class Input(NamedTuple):
    voltage: Annotated[float, "V"]
    brake: Annotated[float, "N m"]


class Parameters(NamedTuple):
    pull: Annotated[float, "rad/s2/V"] = 50.0
    drag: Annotated[float, "1/s"] = 2.0
    load: Annotated[float, "rad/s2"] = 30.0


class Output(NamedTuple):
    angle: Annotated[float, "rad"]
    speed: Annotated[float, "rad/s"]
    power: Annotated[float, "W"]


def derivative(state, input, disturbance, p):
    return State(state.speed, p.pull * input.voltage - p.drag * state.speed - p.load - input.brake)


def output(state, input, disturbance, p):
    return Output(state.angle, state.speed, input.voltage * input.voltage)


def rest(p):
    return State(0.0, 0.0), Input(p.load / p.pull, 0.0)


def position(law, **options):
    return Channel("position", LAWS[law], "angle", "voltage", b0=50.0, limit=10.0, **options)


CASES = {
    "delayed": ([position("pid")], [Actuator("voltage", -6.0, 6.0, delay=0.006, lag=0.004)]),
    "slewed": ([position("ladrc")], [Actuator("voltage", -6.0, 6.0, rate=400.0, delay=0.002)]),
    "free": ([position("hybrid", rate_output="speed")], []),
    "one_sided": ([position("supertwisting")], [Actuator("voltage", low=0.0)]),
    "differenced": ([position("px4_position", every=3)], [Actuator("voltage", -6.0, 6.0)]),
    "cascade": (
        [
            Channel("position", LAWS["pid"], "angle", "turning", b0=4.0, every=5, low=-20.0, high=20.0, limit=10.0),
            Channel("turning", LAWS["pid"], "speed", "voltage", b0=900.0),
        ],
        [Actuator("voltage", -6.0, 6.0)],
    ),
    "shared": (
        [position("pid", high=5.0), Channel("braking", LAWS["pid"], "speed", "voltage", b0=1e5, rate_output="speed", every=3)],
        [Actuator("voltage", -6.0, 6.0)],
    ),
}  # fmt: skip


@cache
def system(case):
    channels, actuators = CASES[case]
    return plant_system(globals(), "drive", channels, actuators, control_period=0.002)


def usual_gains(of):
    return [gain.default for gain in of.gains]


@cache
def files(case, real="double"):
    return plant_files(system(case), usual_gains(system(case)), real=real, name=case)


def written(folder, contents):
    folder.mkdir(exist_ok=True)
    for name, content in contents.items():
        (folder / name).write_bytes(content)
    return folder


def compiled(folder, compiler, flags, *arguments):
    done = subprocess.run([program(compiler), *flags, *arguments, "-lm"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr[-2000:]


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """The controllers of all cases, compiled in one call."""
    folder = tmp_path_factory.mktemp("plants")
    for case in CASES:
        written(folder, files(case))
    sources = [f"{case}_controller.c" for case in CASES]
    compiled(folder, "gcc", STRICT, "-shared", "-fPIC", *sources, "-o", "all.so")
    return ctypes.CDLL(str(folder / "all.so"))


def flight(of, gains):
    """A flight in Python with noise on every output: measurements, references, commands, and memories of its controller."""
    spec = PlantScenario(
        "flight",
        STEPS * of.timing.control_period,
        {each.name: Step(1.0, 0.02) for each in of.plan.outer},
        {},
        {name: SensorNoise(0.002, 0.001) for name in of.plant.Output._fields},
        dict.fromkeys(of.plant.Parameters._fields, 0.1),
    )
    drawn = of.sample(spec, 7, "c99", [0])
    inputs, flights = lane_of(drawn, 0), []
    row = pack(of.loop.records.Gains, gains)
    fly_steps(
        of.loop,
        unchanged,
        row,
        of.nominal,
        inputs,
        drawn.targets,
        of.limits,
        of.timing,
        lambda _, now: flights.append(now),
    )
    seen = np.array([flatten(now.body.shown) for now in flights]) + inputs.noises
    commands = np.array([flatten(now.control.command) for now in flights])
    kept = np.array([flatten(now.control) for now in flights])
    goals = [pack(of.loop.records.Reference, row) for row in inputs.references]
    references = np.array([[leaf for each in of.plan.outer for leaf in getattr(goal, each.name)] for goal in goals])
    return seen, references, commands, kept, np.array(flatten(flights[0].body.actuators))


def assert_same_bits(library, prefix, of, gains):
    """C takes what Python's controller takes in a flight, and must give and keep the same bits."""
    seen, references, commands, kept, held = flight(of, gains)
    read = [of.plant.Output._fields.index(name) for name in tuned_plant(of, gains).Measured._fields]
    seen = np.ascontiguousarray(seen[:, read])
    state, command = np.zeros(size(of.loop.controller.Memory)), np.zeros(size(of.plant.Input))
    init, step = (getattr(library, f"{prefix}_{name}") for name in ("init", "step"))
    assert init(at(state), at(seen[0]), at(held)) == 0
    for k in range(STEPS):
        assert step(at(state), at(references[k]), at(seen[k]), at(command)) == 0
        assert command.tobytes() == commands[k].tobytes(), k
        assert state.tobytes() == kept[k].tobytes(), k
    assert np.ptp(commands, axis=0).max(axis=0) > 0.1


def at(array):
    return array.ctypes.data_as(ctypes.c_void_p)


def as_cell(text, monkeypatch):
    """Names that a notebook has after a cell: its module has no file."""
    monkeypatch.setitem(sys.modules, "cell", ModuleType("cell"))
    names = {"__name__": "cell"}
    exec(compile(text, "<cell>", "exec"), names)
    return names


def lines_of_code(text):
    code = text.replace(text.split('"""')[1], "")
    return [line for line in code.splitlines() if line.strip(' "') and not line.lstrip().startswith("#")]


def test_a_dc_motor_takes_25_lines_from_plant_to_c(tmp_path, monkeypatch):
    text = EXAMPLE.read_text()
    assert len(lines_of_code(text)) <= 25
    monkeypatch.chdir(tmp_path)
    motor = as_cell(text, monkeypatch)["motor"]
    for compiler in ("gcc", "clang"):
        compiled(tmp_path / "motor", compiler, STRICT, "motor_controller.c", "test_golden.c", "-o", compiler)
        done = subprocess.run([f"./{compiler}"], cwd=tmp_path / "motor", capture_output=True, text=True)
        assert (done.returncode, done.stdout) == (0, "the same bits: 200 steps\n")
    compiled(tmp_path / "motor", "gcc", FLAGS, "-shared", "-fPIC", "motor_controller.c", "-o", "motor.so")
    assert_same_bits(ctypes.CDLL(str(tmp_path / "motor" / "motor.so")), "motor", motor, [4.0, 20.0, 0.05, 0.005])


@pytest.mark.parametrize("case", CASES)
def test_c_has_the_bits_of_a_flight_with_noise(library, case):
    assert_same_bits(library, case, system(case), usual_gains(system(case)))


@pytest.mark.parametrize(("case", "compiler"), [("slewed", "gcc"), ("cascade", "clang"), ("one_sided", "gcc")])
def test_float_has_the_bits_of_its_golden_vectors(case, compiler, tmp_path):
    written(tmp_path, files(case, "float"))
    compiled(tmp_path, compiler, STRICT, f"{case}_controller.c", "test_golden.c", "-o", "golden")
    done = subprocess.run(["./golden"], cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "the same bits: 200 steps\n")


@pytest.mark.parametrize("letters", [40, 41, 60, 100, 200])
def test_a_plant_with_a_long_name_compiles(letters, tmp_path):
    """Declarations of names of 60 letters were cut in two, and the export ended with 0."""
    name = "m" * letters
    made = plant_files(system("slewed"), usual_gains(system("slewed")), name=name)
    written(tmp_path, made)
    sources = [each for each in made if each.endswith(".c")]
    compiled(tmp_path, "gcc", STRICT, *sources, "-o", "golden")
    prefix = sources[0].removesuffix("_controller.c")
    other = plant_files(system("slewed"), usual_gains(system("slewed")), name=name + "n")
    assert len(prefix) <= 40 and f"{prefix}_controller.c" not in other


def test_the_source_is_cpp(tmp_path):
    written(tmp_path, files("cascade"))
    flags = ("-x", "c++", "-std=c++11", "-Wall", "-Wextra", "-Werror", "-O2", "-ffp-contract=off")
    compiled(tmp_path, "g++", flags, "cascade_controller.c", "test_golden.c", "-o", "golden")


def test_golden_vectors_notice_every_constant(tmp_path):
    source = files("cascade")["cascade_controller.c"].decode()
    written(tmp_path, files("cascade"))
    flags = ("-std=c99", "-O0", "-ffp-contract=off")
    compiled(tmp_path, "gcc", flags, "-c", "test_golden.c")
    entries = [
        entry
        for table in re.finditer(r"static const \w+ \w+_gains = \{(.*?)\};", source, re.S)
        for entry in re.finditer(r"-?\d[\d.e-]*(?=, /\*)", source[: table.end()])
        if entry.start() > table.start() and float(entry[0]) != 0.0
    ]
    assert len(entries) == 14
    for entry in entries[::4]:
        changed = f"{source[: entry.start()]}{float(entry[0]) * 1.001!r}{source[entry.end() :]}"
        (tmp_path / "mutant.c").write_text(changed)
        compiled(tmp_path, "gcc", flags, "mutant.c", "test_golden.o", "-o", "mutant")
        assert subprocess.run(["./mutant"], cwd=tmp_path, capture_output=True).returncode == 1, entry[0]


def test_the_texts_have_units_laws_and_gains():
    texts = {name: content.decode() for name, content in files("cascade").items()}
    header, source = texts["cascade_controller.h"], texts["cascade_controller.c"]
    for line in (
        "cascade_real acceleration; /* [rad/s2] */",
        "cascade_real voltage; /* [V] */",
        "position      pid, from angle to turning, every 5 periods",
        "cascade_real position; /* [rad/s] */",
    ):
        assert line in header
    assert "/* position.kp = 60 s^-2, position.ki = 60 s^-3, position.kd = 14 s^-1, position.t_f = 0.005 s */" in source
    assert "power" not in header
    assert "| turning | pid, from speed to voltage |" in texts["README.md"]
    late = files("delayed")["delayed_controller.h"].decode()
    assert "act so many periods after they are sent: voltage 3. It does not hold them back." in late


def test_bytes_are_a_function_of_the_plant_and_its_gains():
    of = system("cascade")
    assert plant_files(of, usual_gains(of), real="double", name="cascade") == files("cascade")


@pytest.mark.parametrize(
    ("gains", "told"),
    [
        ([1.0], "given 1 gains; this loop has 4: position.kp, position.ki, position.kd, position.t_f"),
        ([1.0, float("nan"), 1.0, 1.0], "position.ki: given nan; a gain must be finite"),
    ],
)
def test_gains_that_do_not_fit_are_refused(gains, told):
    with pytest.raises(InputError, match=re.escape(told)):
        plant_files(system("delayed"), gains)


@pytest.mark.parametrize("name", ["short", "delete", "größe"])
def test_a_channel_that_c_cannot_name_is_refused(name):
    channel = Channel(name, LAWS["pid"], "angle", "voltage")
    of = plant_system(globals(), "drive", [channel], control_period=0.002)
    with pytest.raises(InputError, match=f"given '{name}', which is no name in C"):
        plant_files(of, [1.0, 1.0, 1.0, 0.01])


def test_a_type_that_c_has_not_is_refused():
    with pytest.raises(UnknownNameError, match="float"):
        plant_files(system("delayed"), usual_gains(system("delayed")), real="half")


def test_a_folder_that_holds_something_is_left_alone(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(StoreError, match="exists already"):
        export_plant(system("delayed"), usual_gains(system("delayed")), tmp_path)
    assert [each.name for each in tmp_path.iterdir()] == ["notes.txt"]


def test_a_plant_step_must_divide_the_control_period():
    with pytest.raises(InputError, match="must be a multiple of plant_step"):
        plant_system(globals(), "drive", [position("pid")], control_period=0.002, plant_step=0.0015)
