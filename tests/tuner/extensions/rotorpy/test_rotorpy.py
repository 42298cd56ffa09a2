"""RotorPy: the exported package computes our bits, and RotorPy itself flies it as our simulation does."""

import importlib
import json
import re
import sys
from dataclasses import replace
from math import cos, radians
from typing import Any

import numpy as np
import pytest

from plant.backends.stepping import Inputs, fly_steps, unchanged
from plant.law_registry import LAWS
from plant.loop import Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.attitude import euler_angles
from plant.quadrotor.cascade import hovering
from plant.quadrotor.closed_loop import Limits
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.rigid_body import Body, dynamics
from plant.quadrotor.sensors import Noise, measure
from plant.quadrotor.trim import trim_of
from plant.records import flatten, pack
from plant.references.track import Reference
from plant.vectors import Rotors, Vec3
from tests.clients import ask
from tests.plant.harness import TARGETS, loop_of, random_quaternion, references
from tests.tuner.exchange.controllers import controller
from tuner.exchange.target import Request
from tuner.extensions.rotorpy.export import PACKAGE
from tuner.extensions.rotorpy.export import TARGET as ROTORPY
from tuner.extensions.rotorpy.vehicle import hub_damping, parameters
from tuner.gains import to_document

STEPS, H = 800, 0.004
# A step of 1 m in x, with enough of the rest that every axis has something to do [m, rad].
TARGET = {"x": 1.0, "y": -0.4, "z": 0.2, "yaw": 0.3}
ZERO = Vec3(0.0, 0.0, 0.0)
LIMITS = Limits(5.0, cos(radians(80.0)))


def gains(axes, **values) -> dict[str, Any]:
    return {f"{axis}__{name}": value for axis in axes for name, value in values.items()}


TUNED = {
    "pid": controller("pid", "pid", **gains("xyz", kp=5.0, ki=0.1, kd=4.5), **gains(("roll", "pitch"), kp=200.0, ki=100.0, kd=24.0)),
    "hybrid": controller(
        "hybrid", "hybrid", **gains("xyz", k1=0.5, k2=3.0, omega_o=6.0, **{"lambda": 2.0}),
        **gains(("roll", "pitch"), k2=15.0, omega_o=40.0, **{"lambda": 10.0}),
    ),
}  # fmt: skip


def on_plain_plant(given):
    """The controller for a vehicle without what RotorPy models otherwise: then both plants are the same equations."""
    vehicle = given.airframe.vehicle._replace(drag_linear=ZERO, drag_quadratic=ZERO, rotor_inertia=0.0)
    return replace(given, airframe=replace(given.airframe, vehicle=vehicle))


def request(given):
    return Request(given, "d" * 64, {})


def write(folder, given, name):
    """Write an export with its package under another name, and return that folder."""
    for file, content in ROTORPY.export(request(given)).files.items():
        target = folder / file.replace(PACKAGE, name)
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content)
    return folder


def ours(given, vehicle=None, steps=STEPS):
    """Positions (steps, 3) of the step at the second control instant, in our own simulation of a vehicle."""
    reference = references(steps, **TARGET)
    reference[0, :13] = 0.0
    none = np.zeros((steps, 0))
    plant = np.array(flatten(dynamics(vehicle or given.airframe.vehicle)))
    start = trim_of(given.airframe.vehicle, [0.0, 0.0, 0.0]).body[0]
    places = []
    fly_steps(
        loop_of(given.cascade.position.name, given.cascade.attitude.name),
        unchanged,
        pack(given.cascade.Gains, given.gains),
        nominal(given.airframe.vehicle, given.options, given.control_period),
        Inputs(plant, start, none, none, reference),
        TARGETS,
        LIMITS,
        Timing(given.control_period, given.plant_step),
        lambda k, flight: places.append(flight.body.position),
    )
    return np.array(places)


FLY = """
import importlib, json, sys
sys.path = [sys.argv[1], *[place for place in sys.path if place]]
import numpy as np
from rotorpy.environments import Environment
from rotorpy.vehicles.multirotor import Multirotor

class Step:
    def update(self, t):
        none = np.zeros(3)
        stepped = 0.0 if t < 0.002 else 1.0
        x, yaw = stepped * np.array([1.0, -0.4, 0.2]), stepped * 0.3
        return {"x": x, "x_dot": none, "x_ddot": none, "x_dddot": none, "x_ddddot": none, "yaw": yaw, "yaw_dot": 0, "yaw_ddot": 0}

found = {}
for case in sys.argv[2:]:
    name, rate, seconds = case.split(":")
    package = importlib.import_module(name)
    vehicle = Multirotor(package.quad_params, package.initial_state(), control_abstraction="cmd_ctbm")
    flight = Environment(vehicle, package.controller(), Step(), sim_rate=float(rate)).run(t_final=float(seconds))
    found[case] = flight["state"]["x"].tolist()
assert not [name for name in sys.modules if name == "plant" or name.startswith(("plant.", "tuner"))]
print(json.dumps(found))
"""


@pytest.fixture(scope="module")
def flown(tmp_path_factory):
    """Flights in RotorPy, in one process: full and plain plants, and twice the control rate."""
    folder = tmp_path_factory.mktemp("rotorpy")
    cases = []
    for name, given in TUNED.items():
        write(folder, on_plain_plant(given), f"{name}_plain")
        write(folder, given, f"{name}_full")
        cases += [f"{name}_plain:250:1.0", f"{name}_full:250:3.2"]
    cases.append("hybrid_plain:500:0.4")
    found = ask("rotorpy", FLY, str(folder), *cases)
    return {case: np.array(places) for case, places in found.items()}


@pytest.mark.parametrize("law", list(TUNED))
def test_the_same_plant_gives_the_same_flight(flown, law):
    """Only the integrators differ. Of a step in the speed of a rotor with 20 ms, ours makes an error of (1/20)^5/120 = 3e-9 in
    1 ms, RotorPy's fifth order one of (1/5)^6/720 = 9e-8 in 4 ms: 1e-7 of g/10 at the most, which a loop of 1 s makes 1e-7 m.
    """
    places = flown[f"{law}_plain:250:1.0"][:250]
    np.testing.assert_allclose(places, ours(on_plain_plant(TUNED[law]), steps=250), rtol=0, atol=1e-7)
    assert places[-1, 0] > 0.5


@pytest.mark.parametrize("law", list(TUNED))
def test_a_step_of_a_metre_reaches_its_target(flown, law):
    places = flown[f"{law}_full:250:3.2"]
    np.testing.assert_allclose(places[-1], [TARGET["x"], TARGET["y"], TARGET["z"]], rtol=0, atol=0.02)


@pytest.mark.parametrize("law", list(TUNED))
def test_the_whole_plant_differs_as_said(flown, law):
    """With the damping that comes with drag at the hubs in our plant too, what is left is drag that grows with rotor speed: thrust
    up by 1/cos 30 deg is rotors faster by 7 %, of a drag of 0.34 m/s2 at 1 m/s, held by a stiffness of some 5 s^-2: 5 mm.
    """
    given = TUNED[law]
    vehicle = given.airframe.vehicle
    places = flown[f"{law}_full:250:3.2"][:STEPS]
    damped = vehicle._replace(rate_damping=hub_damping(vehicle))
    left = np.abs(places - ours(given, damped)).max(axis=(0, 1))
    assert left < 5e-3
    # The damping is what differs most: without it the flights are further apart.
    assert np.abs(places - ours(given)).max(axis=(0, 1)) > 2.0 * left


def test_the_command_is_held_over_the_control_period(flown):
    """At twice the control rate, every second place is the same flight; the integrators' own steps differ."""
    fine, coarse = flown["hybrid_plain:500:0.4"], flown["hybrid_plain:250:1.0"]
    np.testing.assert_allclose(fine[::2][:100], coarse[:100], rtol=0, atol=1e-7)


@pytest.fixture
def load_package(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def load_as(given, name):
        write(tmp_path, given, name)
        importlib.invalidate_caches()
        return importlib.import_module(name)

    yield load_as
    for name in [name for name in sys.modules if name.startswith("copy_of_")]:
        del sys.modules[name]


def random_flight(steps):
    """States of our frames, (position, velocity, attitude, rate), and references; nothing in common from step to step."""
    rng = np.random.default_rng(11)
    vectors = rng.normal(size=(steps, 5, 3))
    return [
        (
            *(Vec3(*map(float, v)) for v in vectors[k][:3]),
            random_quaternion(rng),
            vectors[k][3].tolist(),
            float(rng.uniform(-3, 3)),
        )
        for k in range(steps)
    ]


@pytest.mark.parametrize("delay", [False, True])
@pytest.mark.parametrize("law", list(LAWS))
def test_the_package_computes_our_bits(load_package, law, delay):
    """Its commands are those of the cascade stepped as `plant.quadrotor.closed_loop` steps it, bit for bit."""
    given = controller("pid" if law == "ladrc" else "ladrc", law, options=ControlOptions(delay=delay))
    flyer = load_package(given, f"copy_of_{law}_{delay}").controller()
    assert type(flyer).__module__.startswith("copy_of_")
    cascade, knows = given.cascade, nominal(given.airframe.vehicle, given.options, H)
    constants = cascade.prepare(pack(cascade.Gains, given.gains), H)
    still = Rotors(0.0, 0.0, 0.0, 0.0)
    in_force = pending = Rotors(*[knows.hover] * 4)
    memory = None
    for k, (position, velocity, rate, q, goal, yaw) in enumerate(random_flight(30)):
        m = measure(Body(position, velocity, q, rate, still), euler_angles(q), rate, Noise(ZERO, ZERO, ZERO, ZERO))
        memory = cascade.start(constants, m, knows, hovering(knows)) if memory is None else memory
        wanted = Reference(Vec3(*goal), rate, velocity, 0.0, 0.0, yaw, 0.3, 1.0)
        command, memory = cascade.step(memory, constants, knows, wanted, m, in_force, H)
        in_force, pending = (pending if delay else command), command
        state = {
            "x": np.array(position),
            "v": np.array(velocity),
            "q": np.array([q.x, q.y, q.z, q.w]),
            "w": np.array(rate),
        }
        flat = {"x": np.array(goal), "x_dot": np.array(rate), "x_ddot": np.array(velocity), "yaw": yaw, "yaw_dot": 0.3}
        found = flyer.update(k * H, state, flat)
        assert found["cmd_motor_thrusts"].tolist() == list(in_force)
        between = flyer.update((k + 0.5) * H, {}, flat)
        assert between["cmd_motor_thrusts"].tolist() == list(in_force)


STATE = {"x": np.zeros(3), "v": np.zeros(3), "q": np.array([0.0, 0.0, 0.0, 1.0]), "w": np.zeros(3)}
FLAT = {"x": np.ones(3), "x_dot": np.zeros(3), "x_ddot": np.zeros(3), "yaw": 0.0, "yaw_dot": 0.0}


def test_a_rate_that_does_not_fit_is_refused_and_a_flight_can_be_flown_again(load_package):
    flyer = load_package(TUNED["pid"], "copy_of_pid").controller()
    first = flyer.update(0.0, STATE, FLAT)["cmd_moment"]
    second = flyer.update(H, STATE, FLAT)["cmd_moment"]
    assert first.tolist() != second.tolist()
    for late in (2.2 * H, 3.0 * H):
        with pytest.raises(ValueError, match="multiple of 250 Hz"):
            flyer.update(late, STATE, FLAT)
    assert flyer.update(0.0, STATE, FLAT)["cmd_moment"].tolist() == first.tolist()


def test_force_and_moment_are_what_the_thrusts_sum_to(load_package):
    """Body FLU: thrust on the left rolls to the right, at the rear pitches nose down; asked to the east (+x) the nose goes down."""
    package = load_package(TUNED["pid"], "copy_of_pid")
    found = package.controller().update(0.0, STATE, FLAT)
    front_left, front_right, rear_left, rear_right = found["cmd_motor_thrusts"]
    arm = package.quad_params["rotor_pos"]["r1"][0]
    k = package.quad_params["k_m"] / package.quad_params["k_eta"]
    np.testing.assert_allclose(found["cmd_thrust"], front_left + front_right + rear_left + rear_right)
    np.testing.assert_allclose(
        found["cmd_moment"],
        [
            arm * (front_left + rear_left - front_right - rear_right),
            arm * (rear_left + rear_right - front_left - front_right),
            k * (front_left - front_right - rear_left + rear_right),
        ],
    )
    np.testing.assert_allclose(
        package.quad_params["k_eta"] * found["cmd_motor_speeds"] ** 2, found["cmd_motor_thrusts"]
    )
    assert found["cmd_moment"][1] > 0.0 and found["cmd_moment"][0] < 0.0
    # The attitude asked for leans towards +x and +y: positive pitch, negative roll, as a rotation of the body's z axis.
    x, y, z, w = found["cmd_q"]
    assert 2 * (x * z + w * y) > 0.1 and 2 * (y * z - w * x) > 0.1


def test_the_parameters_are_rotorpys_own():
    """Our airframe made from RotorPy's Hummingbird gives RotorPy's numbers back, to the digits that its file was written with."""
    script = (
        "import json; from rotorpy.vehicles.hummingbird_params import quad_params as q; "
        "print(json.dumps({k: float(v) for k, v in q.items() if not hasattr(v, '__len__')}))"
    )
    theirs = ask("rotorpy", script)
    found = parameters(load("hummingbird-rotorpy").vehicle)
    for name in (
        "mass",
        "Ixx",
        "Iyy",
        "Izz",
        "Ixy",
        "k_eta",
        "k_m",
        "k_d",
        "k_z",
        "c_Dx",
        "c_Dy",
        "c_Dz",
        "tau_m",
        "num_rotors",
    ):
        assert found[name] == pytest.approx(theirs[name], rel=2e-3), name


def test_gyroscopic_and_other_differences_are_said():
    said = " ".join(ROTORPY.export(request(TUNED["pid"])).differences)
    for word in ("250 Hz", "damps the rates by", "gyroscopic", "0.05 m above"):
        assert word in said
    moon = TUNED["pid"].airframe.vehicle._replace(gravity=1.62, lag_down=0.03)
    said = " ".join(
        ROTORPY.export(
            request(replace(TUNED["pid"], airframe=replace(TUNED["pid"].airframe, vehicle=moon)))
        ).differences
    )
    assert "1.62 m/s2" in said and "0.03 s down" in said


def test_what_the_files_say_and_the_rollback(tmp_path):
    bundle = ROTORPY.export(request(TUNED["hybrid"]))
    for name in ("README.md", f"{PACKAGE}/gains.py", f"{PACKAGE}/vehicle_params.py"):
        for word in ("d" * 64, "hummingbird", "hybrid", "gainproof"):
            assert word in bundle.files[name].decode()
    code = b"".join(content for name, content in bundle.files.items() if name.endswith(".py")).decode()
    assert not re.search(r"^\s*(from|import) (plant|tuner|objectives|numba|scipy)\b", code, re.MULTILINE)
    assert bundle.held == TUNED["hybrid"]
    assert b"default gains" in bundle.rollback[f"{PACKAGE}/gains.py"]
    previous = tmp_path / "gains.json"
    previous.write_text(json.dumps(to_document(TUNED["pid"], {})))
    back = ROTORPY.export(replace(request(TUNED["hybrid"]), previous=previous)).rollback
    assert b'"x.kp": 5.0,  # s^-2' in back[f"{PACKAGE}/gains.py"] and f"{PACKAGE}/plant/laws/pid.py" in back


def test_quaternion_convention_is_scalar_last(load_package):
    """A vehicle turned by 90 deg about x is not one turned about z: the scalar stands last."""
    copy = importlib.import_module(f"{load_package(TUNED['pid'], 'copy_of_pid').__name__}.flight_controller")
    half = np.sqrt(0.5)
    m = copy.measured(STATE | {"q": np.array([half, 0.0, 0.0, half])})
    assert m.angles.x == pytest.approx(np.pi / 2) and m.angles.z == pytest.approx(0.0)
    assert tuple(m.thrust_direction) == pytest.approx((0.0, -1.0, 0.0))
