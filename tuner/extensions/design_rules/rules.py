"""Design rules as functions of a process: gain, integral time and derivative time of an ideal PID, or bandwidths of ADRC.

S. Skogestad, J. Process Control 13 (2003) 291-309 (SIMC); K. J. Astrom, T. Hagglund, Advanced PID Control, ISA 2006, sections 6.2
(Ziegler-Nichols), 6.4 (lambda) and 7.4 (AMIGO); G. Herbst, Electronics 2013, 2(3), 246-279 (ADRC).
"""

from dataclasses import dataclass
from math import pi

import numpy as np

from tuner.extensions.design_rules.process import NoProcessError, Path, Process, half_rule

# Shortest closed-loop time of a rule, as a share of the dead time, by default; lambda's over the time constant.
TIGHT, CALM = 1.0, 3.0
# Herbst's: settling time times the pole of the feedback, observer over that pole.
SETTLING, OBSERVER = 4.0, 10.0
# Frequencies among which that of the ultimate gain is sought.
POINTS = 4000


@dataclass(frozen=True)
class IdealPid:
    """Gains of an ideal PID.

    Attributes:
        k: Gain [command per output].
        t_i: Integral time [s].
        t_d: Derivative time [s].
        b: Weight of the set point, None where a rule has none.
        model: Reduced model of the rule in words, "" for the process itself.
        time: Closed-loop time that it aims at [s], None for a rule without one.
    """

    k: float
    t_i: float
    t_d: float = 0.0
    b: float | None = None
    model: str = ""
    time: float | None = None


@dataclass(frozen=True)
class Bandwidths:
    """Bandwidths of ADRC [rad/s], the rule's b0, and its settling time [s]."""

    omega_c: float
    omega_o: float
    b0: float
    time: float


def simc(process: Process, time: float | None) -> IdealPid:
    """Return SIMC's PI, or its series PID as an ideal one.

    It is a PID where the second lag exceeds the dead time. time: closed-loop time constant [s], by default the dead time.
    """
    gain = process.gain
    if process.is_integrating:
        late = process.dead_time
        closed = _time(time, TIGHT * late)
        return IdealPid(1.0 / (gain * (closed + late)), 4.0 * (closed + late), time=closed)
    if len(process.lags) > 1:
        (first, second), late = half_rule(process.lags, process.path.delay, 2)
        if second > late:
            closed, model = (
                _time(time, TIGHT * late),
                f"lags of {first:.4g} s and {second:.4g} s, dead time {late:.4g} s",
            )
            return ideal_of_series(_simc_pi(process.gain, first, late, closed, model), second)
    first, late, model = process.time_constant, process.dead_time, ""
    if process.lags:
        (first,), late = half_rule(process.lags, process.path.delay, 1)
        model = f"a lag of {first:.4g} s, dead time {late:.4g} s"
    return _simc_pi(process.gain, first, late, _time(time, TIGHT * late), model)


def _simc_pi(gain: float, lag: float, late: float, closed: float, model: str) -> IdealPid:
    """Return SIMC's PI of a lag and a dead time; closed: time constant of the closed loop [s]."""
    return IdealPid(lag / (gain * (closed + late)), min(lag, 4.0 * (closed + late)), model=model, time=closed)


def ideal_of_series(pi: IdealPid, t_d: float) -> IdealPid:
    """Return the ideal PID of a PI behind a lead of t_d [s]."""
    factor = 1.0 + t_d / pi.t_i
    return IdealPid(pi.k * factor, pi.t_i * factor, t_d / factor, model=pi.model, time=pi.time)


def lambda_(process: Process, time: float | None) -> IdealPid:
    """Return the PI of lambda tuning; time: lambda [s], by default 3 time constants, or 3 dead times of an integrator."""
    late = process.dead_time
    if process.is_integrating:
        closed = _time(time, CALM * late)
        k = (2.0 * closed + late) / (process.gain * (closed + late) ** 2)
        return IdealPid(k, 2.0 * closed + late, time=closed)
    closed = _time(time, CALM * process.time_constant)
    lag = process.time_constant
    return IdealPid(lag / (process.gain * (closed + late)), lag, time=closed)


def amigo(process: Process, time: float | None) -> IdealPid:
    """Return AMIGO's PID, which has no parameter: Ms about 1.4."""
    _refuse(time, "amigo")
    late, lag = process.dead_time, process.time_constant
    if process.is_integrating:
        return IdealPid(0.45 / (process.gain * late), 8.0 * late, 0.5 * late, 0.0)
    k = (0.2 + 0.45 * lag / late) / process.gain
    t_i = (0.4 * late + 0.8 * lag) / (late + 0.1 * lag) * late
    return IdealPid(k, t_i, 0.5 * late * lag / (0.3 * late + lag), 0.0 if late < lag else 1.0)


def ziegler_nichols(process: Process, time: float | None) -> IdealPid:
    """Return the PID of the frequency method: 0.6 of the ultimate gain, half and an eighth of the ultimate period."""
    _refuse(time, "ziegler-nichols")
    ultimate, period = ultimate_point(process.path)
    sign = 1.0 if process.gain > 0.0 else -1.0
    return IdealPid(0.6 * sign * ultimate, 0.5 * period, 0.125 * period)


def ultimate_point(path: Path) -> tuple[float, float]:
    """Return the ultimate gain [command per output] and its period [s].

    P control oscillates at that gain. NoProcessError where no gain does.
    """
    poles = np.abs(np.linalg.eigvals(path.a))
    slowest = poles[poles > 0.0].min(initial=1.0 / path.delay)
    omega = np.geomspace(0.01 * slowest, 2.0 * pi / path.delay, POINTS)
    response = path.response(omega)
    sign = np.sign(response[0].real) if abs(response[0].real) > abs(response[0].imag) else -np.sign(response[0].imag)
    phase = np.unwrap(np.angle(sign * response))
    below = np.nonzero((phase[:-1] > -pi) & (phase[1:] <= -pi))[0]
    if not len(below):
        raise NoProcessError("no gain makes it oscillate, and Ziegler-Nichols begins at that gain; use simc or amigo")
    i = int(below[0])
    share = (-pi - phase[i]) / (phase[i + 1] - phase[i])
    w = float(omega[i] * (omega[i + 1] / omega[i]) ** share)
    return 1.0 / abs(complex(path.response(np.array([w]))[0])), 2.0 * pi / w


def herbst(process: Process, time: float | None) -> Bandwidths:
    """Return Herbst's first-order ADRC.

    time: settling time [s], by default 4 time constants, or 10 dead times of an integrator.
    """
    default = 10.0 * process.dead_time if process.is_integrating else SETTLING * process.time_constant
    settling = _time(time, default)
    omega_c = SETTLING / settling
    b0 = process.gain if process.is_integrating else process.gain / process.time_constant
    return Bandwidths(omega_c, OBSERVER * omega_c, b0, settling)


def _time(given: float | None, default: float) -> float:
    return default if given is None else given


def _refuse(time: float | None, name: str) -> None:
    """Refuse a time for a rule without one."""
    if time is not None:
        raise NoProcessError(f"{name} has no closed-loop time; remove --time, or use simc, lambda or herbst")
