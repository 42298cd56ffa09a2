"""ROS 2: the YAML as a reader of YAML sees it, its types held against the controllers' schema, and the law of the target re-flown.

The target's law is written here from control_toolbox's rule (p e + i-term + d e', i-term after use, back-calculation from the
clamped command) and compared with our PID step by step.
"""

import json
import re
from dataclasses import replace

import pytest

from plant.errors import InputError
from plant.laws import pid as law
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from plant.quadrotor.cascade import ATTITUDE_AXES, POSITION_AXES
from plant.quadrotor.nominal import ControlOptions
from plant.records import pack
from tests.clients import ask
from tests.tuner.exchange.controllers import controller, pid
from tuner.exchange.target import Request
from tuner.extensions.ros2.export import FILE, SCHEMA, TARGET, double
from tuner.gains import to_document

READ = "import json, sys, yaml; print(json.dumps(yaml.safe_load(open(sys.argv[1]))))"
# Any group with PyYAML will do; cflib brings it.
GROUP = "crazyflie"
TYPES = {"double": float, "string": str, "bool": bool}


def request(given, previous=None):
    return Request(given, "c" * 64, {}, previous)


def parsed(tmp_path, given):
    file = tmp_path / FILE
    file.write_bytes(TARGET.export(request(given)).files[FILE])
    return ask(GROUP, READ, str(file))


def axis_of(document, axis):
    node = "attitude_pid" if axis in ATTITUDE_AXES else "position_pid"
    return document[node]["ros__parameters"]["gains"][axis]


def test_gains_are_torques_and_forces_in_rad_and_metres(tmp_path):
    given = pid("hummingbird-rotorpy", yaw__kp=12.0, x__kp=2.5, z__ki=0.31)
    vehicle = given.airframe.vehicle
    document = parsed(tmp_path, given)
    scales = dict(zip("xyz", [vehicle.mass] * 3, strict=True)) | dict(zip(ATTITUDE_AXES, vehicle.inertia, strict=True))
    gains = pack(given.cascade.Gains, given.gains)
    for axis, scale in scales.items():
        own, found = getattr(gains, axis), axis_of(document, axis)
        assert [found["p"], found["i"], found["d"]] == pytest.approx(
            [scale * own.kp, scale * own.ki, scale * own.kd], rel=1e-15
        )
    # kg m2 times s^-2
    assert axis_of(document, "roll")["p"] == pytest.approx(0.00365 * 90.0)
    assert axis_of(document, "pitch")["p"] == pytest.approx(0.00368 * 90.0)
    assert document["controller_manager"]["ros__parameters"]["update_rate"] == 250


def flown_by_the_target(fields, h, errors, rates):
    """control_toolbox's PID: commands for errors and their derivatives, clamped."""
    term, commands = 0.0, []
    for error, rate in zip(errors, rates, strict=True):
        raw = fields["p"] * error + term + fields["d"] * rate
        command = min(max(raw, fields["u_clamp_min"]), fields["u_clamp_max"])
        term += h * (fields["i"] * error + (command - raw) / fields["tracking_time_constant"])
        term = min(max(term, fields["i_clamp_min"]), fields["i_clamp_max"])
        commands.append(command)
    return commands


@pytest.mark.parametrize("axis", [*ATTITUDE_AXES, *POSITION_AXES])
def test_the_targets_law_is_ours_without_the_filter(tmp_path, axis):
    """Into saturation and out of it again: the same commands to rounding, so p, i, d, order of the integral and windup are ours."""
    given = pid()
    held = pack(given.cascade.Gains, TARGET.export(request(given)).held.gains)
    fields = axis_of(parsed(tmp_path, given), axis)
    vehicle = given.airframe.vehicle
    inertia = (
        getattr(vehicle.inertia, {"roll": "x", "pitch": "y", "yaw": "z"}[axis])
        if axis in ATTITUDE_AXES
        else vehicle.mass
    )
    h, large = given.control_period, 3.0 * fields["u_clamp_max"] / fields["p"]
    values = [large if 50 < k < 120 else 0.02 * large * (k % 7 - 3) for k in range(250)]
    rates = [0.3 * (k % 11 - 5) * large for k in range(250)]
    theirs = flown_by_the_target(fields, h, values, rates)
    gains = getattr(held, axis)
    constants = law.prepare(gains, h)
    memory = law.start(constants, Measured(0.0, 0.0), 0.0)
    excess, ours = 0.0, []
    for value, rate in zip(values, rates, strict=True):
        channel = Channel(1.0 / inertia, 0.0)
        u, memory = law.step(
            memory, constants, channel, Setpoint(0.0, 0.0, 0.0), Measured(-value, -rate), Applied(0.0, excess), h
        )
        command = min(max(u, fields["u_clamp_min"]), fields["u_clamp_max"])
        excess = command - u
        ours.append(command)
    limit = fields["u_clamp_max"]
    saturated = [command for command in theirs if command >= limit]
    assert len(saturated) > 20 and len(saturated) < 240
    # Our excess reaches the integral in the next period, theirs in the same one; both before the next command.
    assert ours == pytest.approx(theirs, abs=1e-9 * limit)


def leaves(table, place=""):
    for name, value in table.items():
        if isinstance(value, dict):
            yield from leaves(value, f"{place}{name}.")
        else:
            yield f"{place}{name}", value


def test_every_field_is_of_the_schemas_type(tmp_path):
    document = parsed(tmp_path, pid(roll__ki=0.0))
    seen = set()
    for node in ("attitude_pid", "position_pid"):
        assert document["controller_manager"]["ros__parameters"][node] == {"type": "pid_controller/PidController"}
        for name, value in leaves(document[node]["ros__parameters"]):
            field = re.sub(r"^gains\.\w+\.", "gains.*.", name)
            seen.add(field)
            kind = SCHEMA[field]
            if kind == "string_array":
                assert value and {type(entry) for entry in value} == {str}
            else:
                assert type(value) is TYPES[kind], (name, value)
    assert seen == set(SCHEMA)
    assert document["attitude_pid"]["ros__parameters"]["reference_and_state_interfaces"] == ["position", "velocity"]
    assert axis_of(document, "roll")["antiwindup_strategy"] == "none"
    assert [axis_of(document, axis)["angle_wraparound"] for axis in ("roll", "pitch", "yaw")] == [False, False, True]


def test_no_exponent_and_always_a_dot():
    """PyYAML takes 8e-5 for a text and ROS takes 1 for an integer."""
    assert [double(value) for value in (8e-5, 1.0, -3e20, 0.1)] == ["0.00008", "1.0", "-300000000000000000000.0", "0.1"]
    given = pid("crazyflie-pybullet", roll__ki=0.01)
    text = TARGET.export(request(given)).files[FILE].decode()
    numbers = re.findall(r"^ {8}\w+: (-?[\d.eE+-]+)$", text, re.MULTILINE)
    assert len(numbers) > 40
    assert all(re.fullmatch(r"-?\d+\.\d+", number) for number in numbers)
    assert any(float(number) < 1e-6 for number in numbers if number[0] != "-")


def test_limits_are_those_of_the_airframe_at_hover(tmp_path):
    given = replace(pid(), options=ControlOptions(tilt_limit=0.4))
    vehicle = given.airframe.vehicle
    document = parsed(tmp_path, given)
    weight = vehicle.mass * vehicle.gravity
    most, least = (4 * vehicle.thrust_coefficient * speed**2 for speed in (vehicle.speed_max, vehicle.speed_min))
    swing = min(most - weight, weight - least) / 4
    assert axis_of(document, "roll")["u_clamp_max"] == pytest.approx(4 * swing * abs(vehicle.rotor_y.r1))
    assert axis_of(document, "yaw")["u_clamp_min"] == pytest.approx(-4 * swing * vehicle.torque_ratio)
    assert axis_of(document, "x")["u_clamp_max"] == pytest.approx(weight * 0.4227932187)
    assert axis_of(document, "z")["u_clamp_max"] == pytest.approx(most - weight)
    assert axis_of(document, "z")["u_clamp_min"] == pytest.approx(-0.8 * weight)


def test_held_is_ours_without_filters():
    given = pid()
    held = TARGET.export(request(given)).held
    for mine, its in zip(pack(given.cascade.Gains, given.gains), pack(given.cascade.Gains, held.gains), strict=True):
        assert its[:3] == pytest.approx(mine[:3], rel=1e-15)
        assert its.t_f == 0.0


def test_observed_rates_become_measured_and_it_is_said():
    given = replace(pid(), options=ControlOptions(attitude_rate="observer"))
    bundle = TARGET.export(request(given))
    assert bundle.held.options.attitude_rate == "measured"
    assert any("observer" in sentence for sentence in bundle.differences)


@pytest.mark.parametrize("period", [0.003, 1.7, 0.0007])
def test_a_period_of_no_whole_rate_is_refused(period):
    with pytest.raises(InputError, match=r"controller\.control_period: given .* Hz"):
        TARGET.export(request(replace(pid(), control_period=period)))


def test_what_the_file_says():
    bundle = TARGET.export(request(pid()))
    for word in ("c" * 64, "hummingbird", "position pid, attitude pid", "gainproof"):
        assert word in bundle.files[FILE].decode()
    for word in ("not filtered", "error of the rate", "u_clamp", "fed forward"):
        assert any(word in sentence for sentence in bundle.differences), word
    assert TARGET.position_laws == TARGET.attitude_laws == ("pid",)
    by_name = {parameter.name: parameter for parameter in bundle.parameters}
    assert (
        by_name["attitude_pid.gains.roll.p"].unit == "N.m/rad" and by_name["position_pid.gains.x.i"].unit == "N/(m.s)"
    )
    assert all(parameter.low <= parameter.held <= parameter.high for parameter in bundle.parameters)


def test_the_rollback_is_the_previous_file_or_gains_or_the_defaults(tmp_path):
    given = pid()
    assert b"default gains" in TARGET.export(request(given)).rollback[FILE]
    flown = tmp_path / "flown.yaml"
    flown.write_text("attitude_pid:\n  ros__parameters:\n    command_interface: effort\n")
    assert TARGET.export(request(given, flown)).rollback[FILE] == flown.read_bytes()
    gains = tmp_path / "gains.json"
    gains.write_text(json.dumps(to_document(pid(roll__kp=99.0), {})))
    back = TARGET.export(request(given, gains)).rollback[FILE].decode()
    assert f"p: {0.0034 * 99.0!r}\n" in back


def test_a_previous_file_that_cannot_be_flown_is_refused(tmp_path):
    flown = tmp_path / "flown.yaml"
    flown.write_text("attitude_pid:\n  gains: {}\n")
    with pytest.raises(InputError, match="ros__parameters"):
        TARGET.export(request(pid(), flown))
    with pytest.raises(InputError, match="no such file"):
        TARGET.export(request(pid(), tmp_path / "none.yaml"))
    flown.write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="UTF-8"):
        TARGET.export(request(pid(), flown))
    gains = tmp_path / "gains.json"
    gains.write_text(json.dumps(to_document(controller("ladrc", "hybrid"), {})))
    with pytest.raises(InputError, match="hybrid.*pid only"):
        TARGET.export(request(pid(), gains))
