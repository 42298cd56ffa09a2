"""PID by the convex-concave procedure, against exhaustive search and the noise of the law itself."""

from dataclasses import replace

import numpy as np
import pytest

from objectives.design import DesignAxis, DesignRequirements, pid_ccp
from objectives.design.pid_ccp import Procedure, design_pid, noise_root, starts, task_of
from plant.law_registry import LAWS
from plant.laws import pid
from plant.laws.channel import Applied, Channel, Measured, Setpoint
from tests.objectives.design.cases import FREE, ROTORS, axis, roomy

LAW = roomy("pid", kp=(1.0, 1000.0), ki=(0.1, 1e5), kd=(1.0, 200.0))
OMEGA = np.geomspace(1.0, 200.0, 120)


def curve(kp: np.ndarray, ki: np.ndarray, kd: np.ndarray, omega: np.ndarray = OMEGA) -> np.ndarray:
    """L for arrays of gains, frequency last: 20 ms lag, 4 ms dead time, 5 ms filter."""
    s = 1j * omega
    plant = np.exp(-0.004 * s) / (0.02 * s + 1.0) / s**2
    gains = [np.asarray(g, dtype=float)[..., None] for g in (kp, ki, kd)]
    return plant * (gains[0] + gains[1] / s + gains[2] * s / (0.005 * s + 1.0))


def is_stable(kp: float, ki: float, kd: float) -> bool:
    """Roots of the closed loop with (1 - sT/2)/(1 + sT/2) for the dead time."""
    controller = np.polyadd(np.polymul([kp, ki], [0.005, 1.0]), [kd, 0.0, 0.0])
    lags = np.polymul(np.polymul([0.005, 1.0], [0.02, 1.0]), [0.002, 1.0])
    closed = np.polyadd(np.polymul([1.0, 0.0, 0.0, 0.0], lags), np.polymul([-0.002, 1.0], controller))
    return bool(np.roots(closed).real.max(axis=0) < 0.0)


def largest_integral(ms: float, mt: float) -> float:
    """The largest ki of any stable (kp, ki, kd) on a grid that keeps both peaks, searched around the known optimum's size."""
    kp, kd = np.meshgrid(np.linspace(40.0, 170.0, 44), np.linspace(14.0, 34.0, 26), indexing="ij")
    for ki in np.geomspace(3000.0, 100.0, 86):
        loop = curve(kp, np.full_like(kp, ki), kd)
        distance = np.abs(1.0 + loop)
        kept = (distance.min(axis=-1) >= 1.0 / ms) & ((np.abs(loop) / distance).max(axis=-1) <= mt)
        if any(is_stable(p, ki, d) for p, d in zip(kp[kept], kd[kept], strict=True)):
            return float(ki)
    return 0.0


def design(requirements: DesignRequirements) -> pid.Gains:
    found = design_pid(axis(LAW), requirements)
    assert found.designed, found.why
    return found.gains


@pytest.mark.parametrize(("ms", "mt"), [(1.7, 1.5), (1.7, 2.0), (2.0, 2.0), (1.5, 1.4)])
def test_integral_gain_is_the_largest_there_is(ms: float, mt: float) -> None:
    """Exhaustive search with its own transfer functions; the grid of ki steps by 4 %."""
    found = design(replace(FREE, ms=ms, mt=mt))
    assert found.ki > 0.97 * largest_integral(ms, mt)
    loop = curve(np.array(found.kp), np.array(found.ki), np.array(found.kd), np.geomspace(0.05, 3000.0, 20000))
    assert np.abs(1.0 + loop).min(axis=-1) > 1.0 / (1.01 * ms)
    assert np.abs(loop / (1.0 + loop)).max(axis=-1) < 1.01 * mt


def test_the_coarse_figure_of_record() -> None:
    """Ms 1.7, 45 deg, 6 dB: ki about 768, kp 77, kd 21. Mt 1.5 is a little stricter on phase than Ms alone."""
    found = design(replace(FREE, ms=1.7, mt=1.5))
    assert 500.0 < found.ki < 1100.0
    assert found.kp == pytest.approx(77.0, rel=0.4)
    assert found.kd == pytest.approx(21.0, rel=0.3)


def test_every_step_keeps_the_requirements_and_gains() -> None:
    requirements = replace(FREE, speed=1.0)
    task = task_of(axis(LAW), requirements)
    procedure = Procedure(task)
    gains = [start for start in starts(axis(LAW), task) if procedure.keeps(start)][-1]
    merits = [procedure.merit(gains)]
    for _ in range(5):
        gains = procedure.improve(gains)
        assert gains is not None
        loop = curve(*gains[:, None])[0]
        assert np.abs(1.0 + loop).min(axis=0) > (1.0 - 1e-3) / requirements.ms
        assert np.abs(loop / (1.0 + loop)).max(axis=0) < (1.0 + 1e-3) * requirements.mt
        merits.append(procedure.merit(gains))
    assert all(after > before - 1e-6 for before, after in zip(merits, merits[1:], strict=False))
    assert merits[-1] > merits[0] + 1.0


def test_speed_trades_integral_for_proportional_gain() -> None:
    slow, fast = design(FREE), design(replace(FREE, speed=4.0))
    assert fast.kp > slow.kp and fast.ki < slow.ki
    assert fast.ki * fast.kp**4 > slow.ki * slow.kp**4


def test_requirements_that_bind() -> None:
    damped = design(replace(FREE, damping=0.9))
    assert damped.kd**2 == pytest.approx(4.0 * 0.81 * damped.kp, rel=1e-3)
    stepped = design(replace(FREE, attitude_step=5.0))
    assert stepped.kp <= 250.0 / 5.0 * (1.0 + 1e-6)
    quiet = replace(FREE, noise=0.0006)
    gains, case = design(quiet), axis(LAW)
    sensors = quiet.sensors
    assert np.linalg.norm(noise_root(case, quiet) @ [gains.kp, gains.kd]) == pytest.approx(0.15, rel=1e-3)
    assert sensors.attitude * gains.kp < 0.15
    narrow = axis(roomy("pid", kp=(1.0, 30.0), ki=(0.1, 1e5), kd=(1.0, 200.0)))
    assert design_pid(narrow, FREE).gains.kp <= 30.0 * (1.0 + 1e-6)


def test_the_best_of_the_starts_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stopped after one step, the starts have come to different places."""
    monkeypatch.setattr(pid_ccp, "ITERATIONS", 1)
    requirements, case = replace(FREE, speed=1.0), axis(LAW)
    task = task_of(case, requirements)
    procedure = Procedure(task)
    kept = [start for start in starts(case, task) if procedure.keeps(start)]
    merits = [procedure.merit(procedure.settle(start)) for start in kept]
    assert len(merits) > 1 and max(merits) > min(merits) + 1.0
    found = design_pid(case, requirements).gains
    assert procedure.merit(np.array([found.kp, found.ki])) == pytest.approx(max(merits), abs=1e-6)


def command_noise(case: DesignAxis, requirements: DesignRequirements, gains: pid.Gains) -> float:
    """RMS of what the law itself commands when it measures nothing but noise."""
    law, h, steps = LAWS["pid"], case.control_period, 40_000
    value, rate = requirements.noises("attitude")
    draw = np.random.default_rng(3).standard_normal((steps, 2)) * [value, rate]
    constants, channel = law.prepare(gains, h), Channel(1.0, float(case.from_observer))
    memory, commands = law.start(constants, Measured(0.0, 0.0), 0.0), []
    for y, v in draw.tolist():
        u, memory = law.step(memory, constants, channel, Setpoint(0.0, 0.0, 0.0), Measured(y, v), Applied(0.0, 0.0), h)
        commands.append(u)
    return float(np.std(commands[200:]))


@pytest.mark.parametrize("observed", [False, True])
def test_command_noise_is_that_of_the_law(observed: bool) -> None:
    """White noise on value and rate; 40 000 samples that hang together over a filter's five, so 1 %."""
    case = axis(LAW, observed=observed)
    gains = pid.Gains(1500.0, 0.0, 20.0, 0.005)
    expected = float(np.linalg.norm(noise_root(case, FREE) @ [gains.kp, gains.kd]))
    assert expected == pytest.approx(command_noise(case, FREE, gains), rel=0.03)


@pytest.mark.parametrize("observed", [False, True])
def test_differencing_costs_phase(observed: bool) -> None:
    found = design_pid(axis(LAW, observed=observed, period=0.004), FREE)
    assert found.designed
    measured = design_pid(axis(LAW, period=0.004), FREE)
    assert (found.load_rejection < 0.95 * measured.load_rejection) is observed


def test_where_nothing_keeps_the_requirements() -> None:
    none = design_pid(axis(roomy("pid", kd=(100.0, 200.0))), FREE)
    assert not none.designed and "PID" in none.why
    assert none.gains == pid.Gains(**LAWS["pid"].defaults("attitude"))
    assert ROTORS.order == 2
