"""A vehicle out of a genuine blackbox file: Betaflight's own program flies our plant, and writes what it hears and commands."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plant.quadrotor.airframes import load
from plant.quadrotor.airframes.actuation import actuation
from plant.quadrotor.attitude import euler_angles
from plant.quadrotor.disturbance import Disturbance
from plant.quadrotor.integrator import runge_kutta_step
from plant.quadrotor.rigid_body import Body, body_rate, dynamics
from plant.records import zeros
from plant.vectors import Quaternion, Rotors, Vec3, to_body
from tests.clients import ask, client
from tests.tuner.extensions.identification.known_flights import GYRO, LIFT, distances
from tests.tuner.extensions.identification.test_frequency_response import distances_from_chirp_core
from tuner.extensions.autopilots.firmware import Bench
from tuner.extensions.autopilots.instants import Instant
from tuner.extensions.betaflight import board
from tuner.extensions.betaflight.bench import install
from tuner.extensions.identification.building import identification_document
from tuner.extensions.identification.identify import identify_vehicle
from tuner.extensions.logs.reading import read_log

AIRFRAME = load("racer5")
PERIOD, SECONDS = 250e-6, 12.0
SETTINGS = b"""set angle_limit = 30
set gyro_lpf1_static_hz = 0
set gyro_lpf2_static_hz = 0
set gyro_lpf1_dyn_min_hz = 0
set acc_lpf_hz = 0
set blackbox_device = VIRTUAL
set blackbox_mode = NORMAL
set blackbox_sample_rate = 1/4
save
"""
# Arming switch off, throttle low: Betaflight ends its log.
DISARMED = (1500, 1500, 950, 1500, 1000, 2000)
DECODE = """
import csv, json, sys
from orangebox import Parser
parser = Parser.load(sys.argv[1])
with open(sys.argv[2], "w", newline="") as file:
    table = csv.writer(file)
    table.writerow(["time (us)" if name == "time" else name for name in parser.field_names])
    table.writerows(frame.data for frame in parser.frames())
print(json.dumps(None))
"""


def flown_vehicle():
    """The vehicle behind the log: other inertias, thrust, lags and yaw torque than the airframe's, and damped by its rotors."""
    known = AIRFRAME.vehicle
    x, y, z = known.inertia
    return known._replace(
        inertia=Vec3(1.2 * x, 0.85 * y, 1.05 * z),
        thrust_coefficient=1.1 * known.thrust_coefficient,
        lag_up=0.8 * known.lag_up,
        lag_down=0.9 * known.lag_down,
        torque_ratio=1.2 * known.torque_ratio,
        rate_damping=Vec3(0.004, 0.004, 0.0),
    )


def turned(body):
    """Roll, pitch and yaw [rad]."""
    return euler_angles(body.attitude)


def powered(folder):
    """The board with a log of its own, set up as a person does it."""
    site = Path(client("betaflight")).parents[1]
    (binary,) = site.glob("lib/python*/site-packages/betaflight/firmware/obj/betaflight_*_SITL")
    return install(Bench(binary, folder, actuation(AIRFRAME.vehicle), PERIOD), SETTINGS)()


def fly(firmware: Any, vehicle, monkeypatch):
    """Arm, shake all axes and climb for a while, and disarm; sticks are sums of sines, and air pushes and turns the vehicle."""
    draw, steps = np.random.default_rng(19), round(SECONDS / PERIOD)
    time = PERIOD * np.arange(steps)[:, None]
    frequency, phase = draw.uniform(0.5, 5.0, (4, 6)), draw.uniform(0.0, 2.0 * np.pi, (4, 6))
    sines = [
        np.sin(2.0 * np.pi * f * time + p).sum(axis=1) / np.sqrt(6.0) for f, p in zip(frequency, phase, strict=True)
    ]
    roll, pitch, yaw, lift = (size * shape for size, shape in zip((0.15, 0.15, 0.8, 0.25), sines, strict=True))
    numbers, still = dynamics(vehicle), zeros(Vec3)
    hover = float(np.sqrt(0.25 * vehicle.mass * vehicle.gravity / vehicle.thrust_coefficient))
    body = Body(still, still, Quaternion(1.0, 0.0, 0.0, 0.0), still, Rotors(*[hover] * 4))
    keep, air = np.exp(-PERIOD / 0.3), np.zeros(6)
    throttle = hover / vehicle.speed_max
    instant = Instant((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0), 0.0, 0.0)
    firmware.arm(
        instant,
        throttle,
        (throttle, throttle, throttle, throttle),
    )
    for k in range(steps):
        air = keep * air + np.sqrt(1.0 - keep**2) * draw.normal(size=6) * [1.0, 1.0, 0.5, 0.2, 0.2, 0.1]
        pushed = Disturbance(still, still, Vec3(*air[3:]), Vec3(*air[:3]))
        velocity = body_rate(body, body.rotor_speed, pushed, numbers).velocity
        felt = np.array(to_body(body.attitude, velocity._replace(z=velocity.z + vehicle.gravity))) + LIFT * draw.normal(
            size=3
        )
        # The bench sends a vehicle at rest; axes as Betaflight's simulator takes them.
        monkeypatch.setattr(board, "AT_REST", (felt[0], -felt[1], -felt[2]))
        rate = np.array(body.rate) + GYRO * draw.normal(size=3)
        throttle = hover / vehicle.speed_max * (1.0 + lift[k] - 0.06 * body.velocity.z - 0.02 * body.position.z)
        p, q, r = rate.tolist()
        instant = Instant(turned(body), (p, q, r), (roll[k], pitch[k]), yaw[k], 0.0)
        share = firmware.step(instant, float(throttle))
        body = runge_kutta_step(body, Rotors(*(x * vehicle.speed_max for x in share)), pushed, numbers, PERIOD)
    for _ in range(round(0.5 / PERIOD)):
        firmware._step(instant, DISARMED)


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    """Folder with a flight's blackbox file, `log.bbl`, and the same decoded by another program, `log.csv`."""
    folder = tmp_path_factory.mktemp("flight")
    firmware = powered(folder / "board")
    try:
        with pytest.MonkeyPatch.context() as monkeypatch:
            fly(firmware, flown_vehicle(), monkeypatch)
        written = Path(firmware._workspace.name) / "LOG00001.BF"
        shutil.copy(written, folder / "log.bbl")
        ask("betaflight", DECODE, str(written), str(folder / "log.csv"))
    finally:
        firmware.close()
    return folder


@pytest.mark.slow
def test_a_blackbox_file_is_read_as_another_program_decodes_it(flight):
    pytest.importorskip("betaflight_chirp_core")
    ours, theirs = (read_log(flight / name) for name in ("log.bbl", "log.csv"))
    for part in ("time", "gyro", "acceleration", "command", "setpoint"):
        assert getattr(ours, part) == pytest.approx(getattr(theirs, part), rel=1e-12, abs=1e-12), part


@pytest.mark.slow
def test_frequency_responses_of_a_genuine_file_are_those_of_betaflight_chirp_core(flight):
    for magnitude, phase, count in distances_from_chirp_core(flight / "log.bbl").values():
        assert magnitude < 0.5 and phase < 5.0 and count > 2


@pytest.mark.slow
def test_the_vehicle_that_betaflight_flew_lies_within_the_intervals(flight):
    vehicle = flown_vehicle()
    found = identify_vehicle([read_log(flight / "log.csv")], AIRFRAME)
    full, (x, y, z) = vehicle.thrust_coefficient * vehicle.speed_max**2, vehicle.inertia
    truth = {
        "inertia.x": x,
        "inertia.y": y,
        "inertia_share": z / (x + y),
        "thrust.30": 0.09 * full,
        "thrust.65": 0.4225 * full,
        "lag_up": vehicle.lag_up,
        "lag_down": vehicle.lag_down,
        "torque_ratio": vehicle.torque_ratio,
        "rate_damping": 0.004,
        "rotor_inertia": 1.1**-0.5,
    }
    deviations = dict(zip(found.space.names, np.sqrt(np.diag(found.fit.covariance)), strict=True))
    told = distances(found, truth)
    assert told.keys() == truth.keys()
    for name, distance in told.items():
        # Commands answer the noise of the gyro within the means that are compared, which takes 5 % off the lags.
        extra = 0.08 if name.startswith("lag") else 0.0
        assert abs(distance) * deviations[name] < 3.5 * deviations[name] + extra, name
    assert max(deviations[name] for name in ("inertia.x", "inertia.y", "lag_up", "lag_down")) < 0.1
    document = identification_document(found, [], None)
    assert "The model agrees with the frequency response of roll, pitch, yaw and lift" in document.verdict
    assert [row.instrument for row in document.responses] == ["setpoint", "setpoint", "setpoint", ""]
