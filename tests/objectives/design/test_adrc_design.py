"""LADRC and hybrid designs against exhaustive search, each other, the laws' models and noise in a sampled loop."""

from dataclasses import replace
from math import sqrt
from typing import Any

import numpy as np
import pytest

from objectives.design import DesignRequirements, adrc_design
from objectives.design.adrc_design import LARGEST_DESCRIBING, design_hybrid, design_ladrc, integral_gain
from objectives.design.expressions import Complex, Feedback, observed, sensitivities
from objectives.design.frequency import closed_matrix, responses
from objectives.design.program import load_rejection
from objectives.linear_axis.channel_model import RotorLag
from plant.law_registry import LAWS
from plant.laws import hybrid, ladrc
from plant.seeds import generator
from tests.objectives.design.cases import FREE, ROTORS, axis, roomy
from tests.objectives.design.discrete import Loop, Rotors, attitude_step

LADRC = roomy("ladrc", omega_c=(0.3, 60.0), zeta=(0.2, 10.0), omega_o=(0.5, 200.0))
HYBRID = roomy("hybrid", lambda_=(0.1, 60.0), k1=(0.0, 1e4), k2=(0.1, 500.0), omega_o=(0.5, 200.0))
# Rate measured; the observer is told the command itself, or the modelled actuator.
BLIND = replace(ROTORS, lag_aware=False)
TIGHT = replace(FREE, ms=1.7, mt=1.5)


def numbers(name: str, a: float, b: float, wo: float, estimated: bool) -> tuple[Any, Feedback]:
    """A law's gains, and the feedback that they amount to."""
    if name == "ladrc":
        return ladrc.Gains(a, b, wo), Feedback(a * a, 2.0 * a * b, wo, estimated, estimated)
    return hybrid.Gains(wo, a, 0.0, b, 0.1), Feedback(a * b, a + b, wo, False, estimated)


@pytest.mark.parametrize("estimated", [False, True])
@pytest.mark.parametrize("name", ["ladrc", "hybrid"])
def test_the_expression_is_the_law(name: str, estimated: bool) -> None:
    """At random gains and frequencies the program's C, S and T are those of the law's state space."""
    draw = generator(8, "tests/gains", 0)
    for _ in range(4):
        a, b, wo, omega = draw.uniform(1.0, 20.0, 4).tolist()
        gains, law = numbers(name, a, b, wo, estimated)
        exact = responses(axis(LAWS[name], observed=estimated).closed(gains), np.array([1j * omega]))
        known, delivered = complex(exact.seen[0]), complex(exact.delivered[0])
        seen = observed(law, Complex(0.0, omega), Complex(known.real, known.imag))
        value, rate, own = (complex(part.re, part.im) for part in seen)
        assert (value + 1j * omega * rate) / own == pytest.approx(complex(exact.feedback_gain()[0]), rel=1e-9)
        names = ("S", "T", "value noise", "rate noise")
        function = sensitivities(law.value_too, law.rate_too, names)
        point = [omega, delivered.real, delivered.imag, known.real, known.imag]
        squares = np.array(function([law.kp, law.kd, wo], point)).ravel()
        loop = complex(exact.loop()[0])
        expected = [1.0, abs(loop), abs(value / own), abs(rate / own)] / np.abs(1.0 + loop)
        np.testing.assert_allclose(squares, expected**2, rtol=1e-9)


@pytest.mark.parametrize("observed_rate", [False, True])
def test_integral_gain_is_the_published_one(observed_rate: bool) -> None:
    """Facts 2.3: kp wo/3 with measured rate; kp b3/(b2 + kd b1 + kp) on estimates; kp/(3/wo + T) knowing an actuator."""
    wc, zeta, wo = 5.0, 0.8, 14.0
    kp, kd = wc**2, 2 * zeta * wc
    gains = ladrc.Gains(wc, zeta, wo)
    law = Feedback(kp, kd, wo, observed_rate, observed_rate)
    plain = kp * wo**3 / (3 * wo**2 + kd * 3 * wo + kp) if observed_rate else kp * wo / 3.0
    assert load_rejection(law, 0.0) == pytest.approx(plain, rel=1e-12)
    exact = integral_gain(axis(LAWS["ladrc"], RotorLag(0.02, 1e-9, False), observed_rate), gains)
    assert exact == pytest.approx(plain, rel=1e-4)
    if not observed_rate:
        assert load_rejection(law, 0.024) == pytest.approx(kp / (3.0 / wo + 0.024), rel=1e-12)
    aware = integral_gain(axis(LAWS["ladrc"], ROTORS, observed_rate), gains)
    assert aware == pytest.approx(load_rejection(law, 0.024), rel=1e-4)


def exhaustive(actuator: RotorLag, requirements: DesignRequirements) -> float:
    """Largest k_i on a grid of (wc, zeta, wo), with its own transfer functions; stable by python-free Nyquist of a PD start."""
    omega = np.geomspace(0.3, 300.0, 150)
    s = 1j * omega
    dead = np.exp(-0.004 * s)
    plant = dead / (0.02 * s + 1.0) / s**2
    known, late = (dead / (0.02 * s + 1.0), 0.024) if actuator.lag_aware else (dead, 0.004)
    best = 0.0
    wo = np.geomspace(3.0, 60.0, 28)[:, None, None]
    q = (wo / (s + wo)) ** 3
    for wc in np.geomspace(4.0, 20.0, 40):
        zeta = np.linspace(0.6, 1.8, 21)[:, None]
        loop = plant * (q * s**2 + 2 * zeta * wc * s + wc**2) / (1.0 - q * known)
        distance = np.abs(1.0 + loop)
        kept = (distance.min(axis=-1) >= 1.0 / requirements.ms) & (
            (np.abs(loop) / distance).max(axis=-1) <= requirements.mt
        )
        # Once |L| < 1/2 for good there is no encirclement left at higher frequencies; the winding up to there is that of a
        # stable loop if the phase at crossover lies above -180 deg.
        crossing = np.abs(np.abs(loop) - 1.0).argmin(axis=-1)
        phase = np.take_along_axis(np.angle(-loop), crossing[..., None], axis=-1)[..., 0]
        k_i = wc**2 / (3.0 / wo[:, 0] + late) * np.ones_like(phase)
        best = max(best, float(np.where(kept & (phase > 0.0), k_i, 0.0).max(axis=None)))
    return best


@pytest.mark.parametrize("actuator", [BLIND, ROTORS], ids=["lag unknown", "lag known"])
def test_load_rejection_is_the_largest_there_is(actuator: RotorLag) -> None:
    """Among observers up to 60 rad/s; the grid is coarse, the program may be better but not worse than 2 %."""
    law = roomy("ladrc", omega_c=(0.3, 60.0), zeta=(0.2, 10.0), omega_o=(3.0, 60.0))
    found = design_ladrc(axis(law, actuator), TIGHT)
    assert found.designed
    best = exhaustive(actuator, TIGHT)
    assert 0.98 * best < found.load_rejection < 1.15 * best


def test_the_order_of_record() -> None:
    """Rate from z2 far below measured rate, and that below an observer that knows the lag; 50, 460 and 3213 coarsely."""
    estimates = design_ladrc(axis(LADRC, BLIND, observed=True), TIGHT)
    gyro = design_ladrc(axis(LADRC, BLIND), TIGHT)
    aware = design_ladrc(axis(LADRC), TIGHT)
    assert estimates.designed and gyro.designed and aware.designed
    assert 20.0 < estimates.load_rejection < 150.0
    assert 400.0 < gyro.load_rejection < 1000.0
    assert 1500.0 < aware.load_rejection < 4000.0
    assert 4.0 * estimates.load_rejection < gyro.load_rejection < 0.6 * aware.load_rejection


def test_a_hybrid_without_power_rate_term_is_ladrc() -> None:
    """lambda k = wc^2 and lambda + k = 2 zeta wc for zeta of 1 and more: two programs, one optimum."""
    requirements = replace(TIGHT, damping=5.0, power_share=0.0)
    law = roomy("ladrc", omega_c=(0.3, 60.0), zeta=(1.0, 10.0), omega_o=(0.5, 60.0))
    linear = design_ladrc(axis(law), requirements)
    same = design_hybrid(axis(roomy("hybrid", lambda_=(0.1, 60.0), k2=(0.1, 500.0), omega_o=(0.5, 60.0))), requirements)
    assert linear.designed and same.designed
    assert same.gains.k1 == 0.0
    assert same.load_rejection == pytest.approx(linear.load_rejection, rel=0.01)
    assert same.gains.lambda_ * same.gains.k2 == pytest.approx(linear.gains.omega_c**2, rel=0.05)


def test_the_hybrid_keeps_its_peaks_at_every_gain_its_term_can_have() -> None:
    requirements = replace(DesignRequirements(), power_share=0.4)
    case = axis(LAWS["hybrid"], period=0.004)
    found = design_hybrid(case, requirements)
    assert found.designed
    gains = found.gains
    largest = LARGEST_DESCRIBING * gains.k1 / sqrt(gains.delta)
    assert largest / (gains.k2 + largest) == pytest.approx(0.4, rel=1e-6)
    assert gains.lambda_ <= gains.k2 * (1.0 + 1e-6)
    omega = np.geomspace(0.05, 700.0, 6000)
    for power in np.linspace(0.0, largest, 9).tolist():
        loop = responses(case.closed(gains), 1j * omega, power).loop()
        assert np.abs(1.0 + loop).min(axis=0) > 1.0 / (1.01 * requirements.ms)
        assert np.abs(loop / (1.0 + loop)).max(axis=0) < 1.01 * requirements.mt
    steepest = closed_matrix(case.closed(gains), 1.5 * gains.k1 / sqrt(gains.delta))
    assert np.linalg.eigvals(steepest).real.max(axis=0) < 0.0
    linear = design_hybrid(case, replace(requirements, power_share=0.0))
    assert linear.load_rejection > found.load_rejection


@pytest.mark.slow
def test_command_noise_is_that_of_the_sampled_loop() -> None:
    """A design at its noise limit, flown with white noise on value and rate; 20 000 samples, correlated over some
    ten, say 2 %; and the observer as sampled is louder than in continuous time by some wo h/2 = 7 %."""
    h, authority = 0.004, 250.0
    requirements = DesignRequirements(noise=0.002)
    rotors = Rotors(0.02, h)
    case = axis(LAWS["ladrc"], RotorLag(0.02, 0.006, True, 2), period=h, authority=authority)
    found = design_ladrc(case, requirements)
    louder = design_ladrc(case, DesignRequirements(noise=0.02))
    assert found.designed and found.load_rejection < 0.98 * louder.load_rejection
    loop = Loop("ladrc", found.gains)
    m, value, rate = loop.memory, *requirements.noises("attitude")
    _, step = attitude_step(loop, rotors)
    x, commands = np.zeros(m + 7), []
    for noise in (generator(9, "tests/noise", 0).standard_normal((20_000, 2)) * [value, rate]).tolist():
        y, v = x[m + 5 :].copy()
        x[m + 5 :] = y + noise[0], v + noise[1]
        _, command = step(x, 0.0)
        after, _ = step(x, command)
        # The noise is the sensor's: the axis itself moves from where it is.
        after[m + 5] -= noise[0] + h * noise[1]
        after[m + 6] -= noise[1]
        x = after
        commands.append(command)
    assert np.std(commands[500:]) == pytest.approx(0.002 * authority, rel=0.09)


def test_ranges_are_kept() -> None:
    estimates = replace(axis(LAWS["ladrc"], observed=True), control_period=0.01)
    slow = design_ladrc(estimates, DesignRequirements())
    assert slow.designed and slow.gains.omega_o == pytest.approx(0.3 / 0.01, rel=1e-6)
    assert slow.gains.omega_o <= 0.3 / 0.01
    heavy = design_ladrc(axis(LAWS["ladrc"], authority=20.0), DesignRequirements(attitude_step=1.0))
    assert heavy.gains.omega_c**2 <= 20.0 * (1.0 + 1e-6)
    damped = design_ladrc(axis(LAWS["ladrc"]), DesignRequirements(damping=0.8))
    assert damped.gains.zeta <= 0.8 * (1.0 + 1e-6)


@pytest.mark.parametrize(("name", "designer"), [("ladrc", design_ladrc), ("hybrid", design_hybrid)])
def test_where_nothing_keeps_the_requirements(name: str, designer: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(adrc_design, "STARTS", adrc_design.STARTS[:1])
    none = designer(axis(LAWS[name], replace(ROTORS, lag=1.0, delay=0.5)), DesignRequirements(attitude_step=100.0))
    assert not none.designed and none.why
    defaults = LAWS[name].defaults("attitude")
    assert none.gains._asdict() == defaults


def test_nothing_is_printed(capfd: pytest.CaptureFixture[str]) -> None:
    design_ladrc(axis(LAWS["ladrc"]), DesignRequirements())
    assert capfd.readouterr() == ("", "")
