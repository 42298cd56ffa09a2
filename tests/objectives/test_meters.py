"""The meters against responses whose metrics have closed forms."""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, exp, log, pi, sin, sqrt

import pytest

from plant.sample import Target
from plant.vectors import Rotors
from tests.objectives.flying import AXES, HOVER, H, Signal, censored, fly, score, target, targets


@dataclass(frozen=True)
class Step:
    """A step from start to final at a time."""

    start: float
    final: float
    time: float

    def signal(self, unit_response: Callable[[float], float]) -> Signal:
        """Return reference and actual value for a response from 0 to 1 that begins at 0."""

        def at(t: float) -> tuple[float, float]:
            since = t - self.time
            if since < -1e-9:
                return self.start, self.start
            return self.final, self.start + (self.final - self.start) * unit_response(max(since, 0.0))

        return at

    def target(self, band: float = 0.05, steady_from: float = 0.0) -> Target:
        """Return the target; the band is given as a share of the step."""
        width = band * abs(self.final - self.start)
        return target(self.start, self.final, self.time, width, self.time, width, steady_from)


STEPS = [
    Step(0.0, 1.0, 0.0),
    Step(0.0, -1.0, 0.0),
    Step(2.0, 5.0, 0.0),
    Step(-3.0, -3.5, 1.0),
    Step(0.2, -0.1, 2.0),
    Step(100.0, 100.001, 0.52),
]
TAU = 0.4
DURATION = 8.0
# Of flights that are over where they are read: steps come by 2 s, and are settled 3 s later.
SHORT = 5.0


def second_order(zeta: float, omega: float) -> Callable[[float], float]:
    """Return the unit step response of omega^2/(s^2 + 2 zeta omega s + omega^2)."""
    damped = omega * sqrt(1.0 - zeta**2)
    return lambda t: 1.0 - exp(-zeta * omega * t) * (cos(damped * t) + zeta * omega / damped * sin(damped * t))


def lag(t: float) -> float:
    """Return the unit step response of a first-order lag."""
    return 1.0 - exp(-t / TAU)


@pytest.mark.parametrize(("zeta", "step"), [*[(0.5, step) for step in STEPS], (0.2, STEPS[2]), (0.7, STEPS[2])])
def test_second_order_overshoot(step: Step, zeta: float) -> None:
    omega = 3.0
    aims = targets(z=step.target())
    value = score("overshoot.z", fly({"z": step.signal(second_order(zeta, omega))}, aims, SHORT), aims, SHORT)
    expected = 100.0 * exp(-pi * zeta / sqrt(1.0 - zeta**2))
    # |y''| <= omega^2, and an instant lies within h/2 of the maximum: at most omega^2 (h/2)^2 / 2 is missed.
    missed = 100.0 * omega**2 * (H / 2.0) ** 2 / 2.0
    rounding = 100.0 * 1e-15 * abs(step.final) / abs(step.final - step.start) + 1e-9
    assert expected - missed - rounding <= value <= expected + rounding


@pytest.mark.parametrize("step", STEPS)
def test_lag_does_not_overshoot_and_its_peak_error_is_the_step(step: Step) -> None:
    aims = targets(roll=step.target())
    meters = fly({"roll": step.signal(lag)}, aims, SHORT)
    assert score("overshoot.roll", meters, aims, SHORT) == 0.0
    assert score("peak.roll", meters, aims, SHORT) == pytest.approx(abs(step.final - step.start), rel=1e-12)


@pytest.mark.parametrize("step", STEPS)
def test_lag_rise_time(step: Step) -> None:
    aims = targets(x=step.target())
    meters = fly({"x": step.signal(lag)}, aims, SHORT)
    # Linear interpolation errs by at most h^2/8 |y''| in y, so h^2/(8 tau) in t at each crossing (|y''| = |y'|/tau; 5 %
    # for its change within a period). 1e-9 for rounding, 1e-13 of 100 where the step is 0.001 and y' = 0.1/tau of that.
    tolerance = 2.0 * 1.05 * H**2 / (8.0 * TAU) + 1e-9
    assert score("rise.x", meters, aims, SHORT) == pytest.approx(TAU * log(9.0), abs=tolerance)
    assert not censored("rise.x", meters, aims, SHORT)


@pytest.mark.parametrize("step", STEPS)
@pytest.mark.parametrize("band", [0.02, 0.05])
def test_lag_settling_and_recovery_time(step: Step, band: float) -> None:
    aims = targets(y=step.target(band))
    meters = fly({"y": step.signal(lag)}, aims, SHORT)
    exact = TAU * log(1.0 / band)
    # The first instant inside the band lies within one period after the exact time.
    for metric in ("settling.y", "recovery.y"):
        assert exact - 1e-9 <= score(metric, meters, aims, SHORT) <= exact + H + 1e-9
        assert not censored(metric, meters, aims, SHORT)


@pytest.mark.parametrize("amplitude", [1.0, -2.5])
def test_error_sums_equal_geometric_series(amplitude: float) -> None:
    aims, n, q = targets(), round(DURATION / H), exp(-H / TAU)
    meters = fly({"z": lambda t: (7.0, 7.0 - amplitude * exp(-t / TAU))}, aims, DURATION)
    size = abs(amplitude)
    # sum q^k and sum k q^k, k < n, in closed form; 1 - q = 0.01 costs four digits.
    plain = (1.0 - q**n) / (1.0 - q)
    weighted = q * (1.0 - n * q ** (n - 1) + (n - 1) * q**n) / (1.0 - q) ** 2
    square = (1.0 - q ** (2 * n)) / (1.0 - q**2)
    assert score("iae.z", meters, aims, DURATION) == pytest.approx(size * H * plain, rel=1e-10)
    assert score("itae.z", meters, aims, DURATION) == pytest.approx(size * 2.0 / n**2 * weighted, rel=1e-10)
    assert score("ise.z", meters, aims, DURATION) == pytest.approx(size**2 * H * square, rel=1e-10)
    assert score("rms.z", meters, aims, DURATION) == pytest.approx(size * sqrt(square / n), rel=1e-10)


@pytest.mark.parametrize("step", STEPS)
def test_itae_approaches_its_integral(step: Step) -> None:
    aims = targets(yaw=step.target())
    size, left = abs(step.final - step.start), DURATION - step.time
    rest = exp(-left / TAU)
    integral = size * (step.time * TAU * (1.0 - rest) + TAU**2 * (1.0 - (1.0 + left / TAU) * rest))
    value = score("itae.yaw", fly({"yaw": step.signal(lag)}, aims, DURATION), aims, DURATION) * DURATION**2 / 2.0
    # A Riemann sum is off by at most h times the total variation; t|e| rises once and falls once: 2 max(t|e|).
    largest = size * max(step.time, TAU * exp(step.time / TAU - 1.0) if step.time < TAU else 0.0)
    assert value == pytest.approx(integral, abs=2.0 * H * largest)


def test_persistent_error_makes_itae_its_mean() -> None:
    aims = targets()
    value = score("itae.pitch", fly({"pitch": lambda t: (0.0, 0.3)}, aims, DURATION), aims, DURATION)
    # 2/N^2 sum k = (N - 1)/N of the constant error.
    assert value == pytest.approx(0.3 * (1.0 - H / DURATION), rel=1e-12)


@pytest.mark.parametrize("offset", [0.3, -0.3])
def test_steady_error_sees_only_its_window(offset: float) -> None:
    aims = targets(x=target(steady_from=6.0))
    meters = fly({"x": lambda t: (1.0, 1.0 - (offset if t > 6.0 - 1e-9 else 9.0))}, aims, DURATION)
    assert score("steady_error.x", meters, aims, DURATION) == pytest.approx(0.3, rel=1e-10)


def test_steady_error_is_a_mean_and_not_a_mean_size() -> None:
    aims = targets(x=target(steady_from=4.0))
    meters = fly({"x": lambda t: (0.0, 0.2 if round(t / H) % 2 else -0.2)}, aims, DURATION)
    assert score("steady_error.x", meters, aims, DURATION) == pytest.approx(0.0, abs=1e-12)


def outside_between(*spans: tuple[float, float]) -> Signal:
    """Return a signal with error 1 during the spans [from, to) and exactly on the band, 0.05, elsewhere."""
    return lambda t: (0.0, 1.0 if any(a - 1e-9 <= t < b - 1e-9 for a, b in spans) else 0.05)


def test_settling_counts_the_last_excursion_after_the_step() -> None:
    aims = targets(z=target(time=1.0, recovery_from=5.0))
    meters = fly({"z": outside_between((0.2, 0.4), (1.5, 2.0), (3.0, 3.2))}, aims, DURATION)
    assert score("settling.z", meters, aims, DURATION) == pytest.approx(2.2, abs=1e-9)
    assert score("recovery.z", meters, aims, DURATION) == 0.0


def test_settling_is_zero_where_the_error_never_left_the_band() -> None:
    aims = targets(z=target(time=1.0))
    meters = fly({"z": outside_between((0.2, 0.9))}, aims, DURATION)
    assert score("settling.z", meters, aims, DURATION) == 0.0
    assert not censored("settling.z", meters, aims, DURATION)


def test_settling_and_recovery_are_censored_at_the_time_left() -> None:
    aims = targets(z=target(time=1.0, recovery_from=5.0))
    meters = fly({"z": outside_between((DURATION - H, DURATION))}, aims, DURATION)
    for metric, left in (("settling.z", 7.0), ("recovery.z", 3.0)):
        assert score(metric, meters, aims, DURATION) == pytest.approx(left, abs=1e-9)
        assert censored(metric, meters, aims, DURATION)


def test_settling_one_period_before_the_end_is_not_censored() -> None:
    aims = targets(z=target())
    meters = fly({"z": outside_between((0.0, DURATION - H))}, aims, DURATION)
    assert score("settling.z", meters, aims, DURATION) == pytest.approx(DURATION - H, abs=1e-9)
    assert not censored("settling.z", meters, aims, DURATION)


def test_an_instant_that_rounding_puts_before_the_step_counts() -> None:
    moment = 0.1 + 0.2
    assert 75 * H < moment
    aims = targets(z=target(time=moment))
    meters = fly({"z": outside_between((75 * H, 76 * H))}, aims, DURATION)
    assert score("settling.z", meters, aims, DURATION) == pytest.approx(H, abs=1e-9)


def test_rise_that_never_ends_is_censored_at_the_time_left() -> None:
    step = Step(0.0, 2.0, 1.0)
    aims = targets(z=step.target())
    meters = fly({"z": step.signal(lambda t: 0.89 * lag(t))}, aims, DURATION)
    assert score("rise.z", meters, aims, DURATION) == pytest.approx(7.0, abs=1e-12)
    assert censored("rise.z", meters, aims, DURATION)


def test_rise_keeps_the_first_crossing() -> None:
    # y = 1 - cos(pi t): 10 % at acos(0.9)/pi, 90 % at acos(0.1)/pi, crossed again every 2 s.
    step = Step(0.0, 1.0, 0.0)
    aims = targets(z=step.target())
    meters = fly({"z": step.signal(lambda t: 1.0 - cos(pi * t))}, aims, DURATION)
    # acos(0.9) = 0.45102681179626236, acos(0.1) = 1.4706289056333368; interpolation as above with |y''/y'| < 6.5.
    assert score("rise.z", meters, aims, DURATION) == pytest.approx((1.47062890563 - 0.45102681180) / pi, abs=3e-5)


def test_rise_within_one_period_is_interpolated() -> None:
    step = Step(4.0, 2.0, 1.0)
    aims = targets(z=step.target())
    meters = fly({"z": step.signal(lambda t: 1.0 if t > 0.0 else 0.0)}, aims, DURATION)
    assert score("rise.z", meters, aims, DURATION) == pytest.approx(0.8 * H, rel=1e-9)


def test_rise_of_an_axis_already_past_the_step_is_zero() -> None:
    step = Step(0.0, 1.0, 1.0)
    aims = targets(z=step.target())
    meters = fly({"z": lambda t: (1.0, 1.2)}, aims, DURATION)
    assert score("rise.z", meters, aims, DURATION) == 0.0
    assert not censored("rise.z", meters, aims, DURATION)


def test_rise_does_not_begin_before_the_step() -> None:
    # Half the step is there at once, the other half one period later: 10 % at the step, 90 % after 0.8 of the period.
    step = Step(1.0, 3.0, 1.0)
    aims = targets(z=step.target())
    meters = fly({"z": step.signal(lambda t: 1.0 if t > 0.5 * H else 0.5)}, aims, DURATION)
    assert score("rise.z", meters, aims, DURATION) == pytest.approx(0.8 * H, rel=1e-9)


def test_overshoot_before_the_step_does_not_count() -> None:
    step = Step(0.0, 1.0, 1.0)
    aims = targets(z=step.target())
    meters = fly({"z": lambda t: (0.0, 3.0) if t < 1.0 - 1e-9 else (1.0, 1.25)}, aims, DURATION)
    assert score("overshoot.z", meters, aims, DURATION) == pytest.approx(25.0, rel=1e-12)


def test_step_metrics_of_an_axis_without_step_are_empty() -> None:
    aims = targets(z=target(start=2.0, final=2.0))
    meters = fly({"z": lambda t: (2.0, 2.0 + sin(t))}, aims, DURATION)
    assert score("overshoot.z", meters, aims, DURATION) == 0.0
    assert score("rise.z", meters, aims, DURATION) == 0.0
    assert not censored("rise.z", meters, aims, DURATION)


def test_command_metrics() -> None:
    def command(k: int) -> Rotors:
        return Rotors(1.3 if k % 2 == 0 else 1.0, 0.8, 1.0, 1.0) if k >= 0 else HOVER

    aims = targets()
    meters = fly({}, aims, DURATION, command=command, saturated=lambda k: 1.0 if k % 4 == 0 else 0.0)
    # Rotor 1 moves 0.3 in every period, rotor 2 moves 0.2 once.
    assert score("travel", meters, aims, DURATION) == pytest.approx(0.3 / H + 0.2 / DURATION, rel=1e-10)
    assert score("effort", meters, aims, DURATION) == pytest.approx(0.3**2 / 2.0 + 0.2**2, rel=1e-10)
    assert score("saturation", meters, aims, DURATION) == pytest.approx(0.25, rel=1e-10)
    assert score("command_peak", meters, aims, DURATION) == 1.3
    assert score("failure", meters, aims, DURATION) == 0.0


@pytest.mark.parametrize("rotor", range(4))
def test_every_rotor_counts(rotor: int) -> None:
    def command(k: int) -> Rotors:
        return Rotors(*(1.5 if i == rotor and k == 10 else 1.0 for i in range(4)))

    aims = targets()
    meters = fly({}, aims, DURATION, command=command)
    assert score("travel", meters, aims, DURATION) == pytest.approx(1.0 / DURATION, rel=1e-12)
    assert score("effort", meters, aims, DURATION) == pytest.approx(0.25 * H / DURATION, rel=1e-12)
    assert score("command_peak", meters, aims, DURATION) == 1.5


@pytest.mark.parametrize("axis", AXES)
def test_an_axis_is_judged_by_its_own_signal_and_target(axis: str) -> None:
    step = Step(1.0, 2.0, 1.0)
    aims = targets(**{axis: step.target()})
    meters = fly({axis: step.signal(second_order(0.3, 4.0))}, aims, DURATION)
    for name in ("itae", "iae", "ise", "rms", "peak", "overshoot", "rise", "settling", "recovery", "steady_error"):
        for other in AXES:
            assert (score(f"{name}.{other}", meters, aims, DURATION) > 0.0) == (other == axis)


ODD = second_order(0.25, 5.0)


@pytest.mark.parametrize(
    ("step", "size", "delay"),
    [
        (Step(5.0, 6.0, 0.0), 1.0, 0.0),
        (Step(0.0, -1.0, 0.0), 1.0, 0.0),
        (Step(-2.0, -5.0, 0.0), 3.0, 0.0),
        (Step(0.5, 0.25, 2.0), 0.25, 2.0),
    ],
)
def test_moved_mirrored_and_scaled_steps_score_alike(step: Step, size: float, delay: float) -> None:
    plain = Step(0.0, 1.0, 0.0)
    duration = 6.0
    reference, aims = targets(z=plain.target(steady_from=1.0)), targets(z=step.target(steady_from=1.0 + delay))
    first = fly({"z": plain.signal(ODD)}, reference, duration)
    second = fly({"z": step.signal(ODD)}, aims, duration + delay)

    def pair(name: str) -> tuple[float, float]:
        return score(f"{name}.z", first, reference, duration), score(f"{name}.z", second, aims, duration + delay)

    for name, power in {"overshoot": 0, "rise": 0, "settling": 0, "recovery": 0, "iae": 1, "peak": 1, "ise": 2}.items():
        before, after = pair(name)
        assert after == pytest.approx(before * size**power, rel=1e-9), name
    before, after = pair("steady_error")
    assert after == pytest.approx(before * size, rel=1e-7)
