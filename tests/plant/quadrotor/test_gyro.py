"""The rate that a gyro hears through its rotors and its frame, against closed forms, SciPy's filters and a hub on a spring."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import signal

from objectives import meters
from plant.backends.flyer import Flyer
from plant.backends.stepping import fly_steps, unchanged
from plant.errors import InputError
from plant.law_registry import LAWS
from plant.loop import MeterModel, Timing
from plant.quadrotor.airframes import load
from plant.quadrotor.cascade import close_cascade
from plant.quadrotor.closed_loop import close_loop
from plant.quadrotor.features import BARE, vehicle_features
from plant.quadrotor.gyro import NoiseAndTurns
from plant.quadrotor.nominal import ControlOptions, nominal
from plant.quadrotor.rigid_body import Body
from plant.quadrotor.scenarios import ScenarioSpec, for_vehicle, sample_scenarios
from plant.quadrotor.vehicle import Vehicle
from plant.records import flatten, pack, size
from plant.references.hover import Hover
from plant.vectors import Quaternion, Rotors, Vec3
from tests.plant.harness import HUMMINGBIRD, LIMITS, TARGETS, batch, default_gains, in_blocks, references, scenario

H = 0.001
STEPS = 2000
METER = MeterModel(meters.Meters, meters.start, meters.update)
LOUD = HUMMINGBIRD._replace(vibration_1=0.05, vibration_2=0.03, vibration_3=0.02)
MODE = {"mode_frequency": 90.0, "mode_damping": 0.04, "mode_gain": -0.3}
STILL = Vec3(0.0, 0.0, 0.0)
SILENT = NoiseAndTurns(STILL, STILL, STILL, STILL, Rotors(0.1, 0.2, 0.3, 0.4))
HOVER_SPEED = np.sqrt(HUMMINGBIRD.mass * HUMMINGBIRD.gravity / 4.0 / HUMMINGBIRD.thrust_coefficient)


def heard(vehicle: Vehicle, rates: Any, speeds: Any) -> Any:
    """What the gyro makes (K, 3) of body rates (K, 3) [rad/s] while rotors turn at speeds (K, 4) [rad/s]."""
    gyro, know = vehicle_features(vehicle, H).gyro, nominal(vehicle, ControlOptions(), H)
    bodies = [
        Body(STILL, STILL, Quaternion(1.0, 0.0, 0.0, 0.0), Vec3(*rate), Rotors(*speed))
        for rate, speed in zip(rates, speeds, strict=True)
    ]
    memory, out = gyro.start(bodies[0], know), []
    for body in bodies:
        rate, memory = gyro.hear(memory, body, SILENT, know, H)
        out.append(rate)
    return np.array(out)


def amplitudes(samples: Any) -> Any:
    """Amplitude (K/2 + 1, 3) of every whole frequency of samples (K, 3), by the discrete Fourier transform."""
    return 2.0 * np.abs(np.fft.rfft(samples, axis=0)) / len(samples)


@pytest.mark.parametrize("cutoff", [0.0, 120.0])
def test_lines_stand_where_rotors_turn(cutoff: float) -> None:
    """Each rotor has three, as strong as its squared speed and the low-pass make them; those above 500 Hz fold down."""
    turns = np.array([41.0, 53.5, 67.0, 211.0])
    level = np.array([0.05, 0.03, 0.02])
    vehicle = LOUD._replace(gyro_cutoff=cutoff)
    found = amplitudes(heard(vehicle, np.zeros((STEPS, 3)), np.tile(2.0 * np.pi * turns, (STEPS, 1))))
    wanted = np.zeros(len(found))
    for speed in turns:
        for n in (1, 2, 3):
            there = (n * speed) % 1000.0
            passed = 1.0 / np.sqrt(1.0 + (n * speed / cutoff) ** 4) if cutoff else 1.0
            line = round(min(there, 1000.0 - there) * STEPS * H)
            wanted[line] += level[n - 1] * (2.0 * np.pi * speed / HOVER_SPEED) ** 2 * passed
    assert np.count_nonzero(wanted) == 12
    assert found[:, :2] == pytest.approx(np.stack([wanted, wanted], axis=1), rel=1e-8, abs=1e-9)
    # A rotor at (x, y) turns the frame by x left - y ahead, over their length: as strong as the two others.
    assert found[:, 2] == pytest.approx(wanted, rel=1e-8, abs=1e-9)


def test_a_line_follows_its_rotor() -> None:
    """Of rotors that speed up, it crosses zero as often as they turn, and its size grows with the square of the speed."""
    speed = np.linspace(0.8, 1.2, STEPS) * HOVER_SPEED
    vehicle = HUMMINGBIRD._replace(vibration_1=0.05)
    speeds = np.stack([speed, *[np.zeros(STEPS)] * 3], axis=1)
    roll = heard(vehicle, np.zeros((STEPS, 3)), speeds)[:, 0]
    for half in (slice(0, STEPS // 2), slice(STEPS // 2, STEPS)):
        upward = np.count_nonzero((roll[half][:-1] < 0.0) & (roll[half][1:] >= 0.0))
        assert upward == pytest.approx(H * speed[half].sum() / (2.0 * np.pi), abs=1.0)
        assert roll[half].max() == pytest.approx(0.05 * (speed[half][-1] / HOVER_SPEED) ** 2, rel=0.05)


def test_the_rate_goes_through_mode_and_low_pass() -> None:
    """As through SciPy's bilinear transforms of the two, prewarped to the mode and to the cut-off, axis by axis."""
    rng = np.random.default_rng(7)
    rates = np.cumsum(rng.standard_normal((400, 3)), axis=0)
    rates[:, 2] = 0.0
    w, z, g = 2.0 * np.pi * MODE["mode_frequency"], MODE["mode_damping"], MODE["mode_gain"]
    # fs is chosen so that the transform keeps the frequency of the mode.
    fs = w / (2.0 * np.tan(0.5 * w * H))
    b, a = signal.bilinear([1.0 + g, 2.0 * z * w, w * w], [1.0, 2.0 * z * w, w * w], fs)
    bent = signal.lfilter(b, a, rates - rates[0], axis=0)
    smooth: Any = signal.butter(2, 150.0, fs=1.0 / H)
    wanted = rates[0] + signal.lfilter(smooth[0], smooth[1], bent, axis=0)
    found = heard(HUMMINGBIRD._replace(**MODE, gyro_cutoff=150.0), rates, np.zeros((400, 4)))
    assert found == pytest.approx(wanted, rel=1e-9, abs=1e-9)


def test_the_mode_is_that_of_a_hub_on_a_spring() -> None:
    """Arms with rotors of inertia Ja on a hub with the gyro, Jh: far below the control rate, the hub's rate over that of a rigid
    body is the mode of gain -1 at the frequency where the two swing against each other.
    """
    arms, hub, spring = 2e-3, 1e-3, 300.0
    swinging = np.sqrt(spring * (1.0 / arms + 1.0 / hub))
    vehicle = HUMMINGBIRD._replace(mode_frequency=swinging / (2.0 * np.pi), mode_damping=1e-6, mode_gain=-1.0)
    section = nominal(vehicle, ControlOptions(), 1e-5).gyro.mode
    for w in (0.3 * swinging, 0.9 * swinging, 1.6 * swinging):
        s, z = 1j * w, np.exp(1j * w * 1e-5)
        angles = np.linalg.solve([[arms * s * s + spring, -spring], [-spring, hub * s * s + spring]], [1.0, 0.0])
        rigid = 1.0 / ((arms + hub) * s * s)
        found = (section.b0 + section.b1 / z + section.b2 / z**2) / (1.0 + section.a1 / z + section.a2 / z**2)
        assert found == pytest.approx(angles[1] / rigid, rel=1e-3)


def test_a_vehicle_without_them_flies_the_loop_of_before() -> None:
    """Nothing is kept, nothing is drawn and the kernel has its name."""
    assert vehicle_features(HUMMINGBIRD, H) == BARE
    assert size(BARE.gyro.Memory) == 0
    assert BARE.name == ""
    assert vehicle_features(LOUD._replace(**MODE, gyro_cutoff=90.0), H).name == "_vibrates_flexes_filters"


def test_errors_of_sensors_are_those_of_a_quiet_vehicle() -> None:
    """Turns of the rotors come from a stream of their own, constant over a flight, and another vehicle gets or loses them."""
    spec, timing, indices = ScenarioSpec("hover", 0.1, Hover()), Timing(H, H), range(18)
    quiet, loud = (sample_scenarios(spec, vehicle, timing, 3, "search", indices) for vehicle in (HUMMINGBIRD, LOUD))
    assert np.array_equal(loud.noises[:, :, :12], quiet.noises)
    turns = loud.noises[:, :, 12:]
    assert np.array_equal(turns, np.broadcast_to(turns[:, :1], turns.shape))
    assert len(np.unique(turns)) == 18 * 4
    assert np.array_equal(for_vehicle(quiet, spec, LOUD, 3, "search", indices).noises, loud.noises)
    assert np.array_equal(for_vehicle(loud, spec, HUMMINGBIRD, 3, "search", indices).noises, quiet.noises)


@pytest.mark.slow
def test_lanes_hear_what_python_hears() -> None:
    """Kernels and plain Python agree on a flight with all that a vehicle and its controller may be fitted with."""
    pack_of_cells = {
        "battery_full": 12.6,
        "battery_empty": 10.5,
        "battery_resistance": 0.06,
        "battery_capacity": 7200.0,
        "hover_power": 90.0,
    }
    vehicle, timing = LOUD._replace(**MODE, **pack_of_cells, gyro_cutoff=150.0, dead_time=2.0 * H), Timing(H, H)
    loop = close_loop(close_cascade(LAWS["pid"], LAWS["pid"]), METER, vehicle_features(vehicle, H, 2))
    options = ControlOptions(rpm_notches=2, rpm_notch_min=40.0, battery_compensation=0.5)
    know, noise = nominal(vehicle, options, H), np.zeros((2, 60, 16))
    noise[:, :, 12:] = np.random.default_rng(3).uniform(size=(2, 1, 4))
    inputs = batch([vehicle, vehicle], np.zeros((2, 60, 12)), noise, references(60, z=0.2))
    row = np.array(flatten(default_gains(loop)))
    lanes = Flyer(loop, LIMITS, timing, 1).trace(row, know, in_blocks(inputs))
    for lane in (0, 1):
        seen: list[Any] = []
        fly_steps(
            loop,
            unchanged,
            pack(loop.cascade.Gains, row.tolist()),
            know,
            scenario(inputs, lane),
            TARGETS,
            LIMITS,
            timing,
            lambda _, flight, seen=seen: seen.append(flatten(flight)),
        )
        assert lanes[lane][:, : len(seen[0])] == pytest.approx(np.array(seen), rel=1e-9, abs=1e-9)
    assert np.abs(lanes[0, 50] - lanes[1, 50]).max() > 1e-3


def test_an_airframe_file_may_give_them(tmp_path: Path) -> None:
    """All are 0 where it is silent; a mode needs its three numbers, and a control rate that samples it."""
    text = load("f450").path.read_text(encoding="utf-8")
    units = {"vibration_1": "rad/s", "gyro_cutoff": "Hz", "mode_frequency": "Hz", "mode_damping": "1", "mode_gain": "1"}

    def written(**values: float) -> Path:
        lines = [f'{k} = {{ value = {v}, unit = "{units[k]}", source = "a test" }}\n' for k, v in values.items()]
        file = tmp_path / "loud.toml"
        file.write_text(text.replace("[inertia]", "".join(lines) + "\n[inertia]", 1), encoding="utf-8")
        return file

    given = {"vibration_1": 0.05, "gyro_cutoff": 250.0, **MODE}
    assert load(written(**given)).vehicle == load("f450").vehicle._replace(**given)
    with pytest.raises(InputError, match="mode_damping: is missing"):
        load(written(mode_frequency=90.0, mode_gain=0.1))
    with pytest.raises(InputError, match="100 Hz, is sampled"):
        vehicle_features(HUMMINGBIRD._replace(**MODE | {"mode_frequency": 101.0}), 0.004)
