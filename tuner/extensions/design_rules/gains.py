"""Gains of a rule in the parameters of a channel's law."""

from math import sqrt

from plant.laws.law import Law
from tuner.extensions.design_rules.process import NoProcessError
from tuner.extensions.design_rules.rules import Bandwidths, IdealPid
from tuner.gains.ranges import MAX_BANDWIDTH_PERIODS

PARALLEL = {"pid", "pid_parallel", "pid_incremental"}
LAWS_OF_PID = "pid, pid_parallel, pid_ideal, pid_series, pid_incremental"


def pid_gains(law: Law, pid: IdealPid, b0: float) -> dict[str, float]:
    """Return the gains of a law for an ideal PID.

    They are multiplied by b0, as the law divides by it. NoProcessError for a law that is no PID.
    """
    k = pid.k * b0
    weight = {"b": pid.b} if pid.b is not None and "b" in law.Gains._fields else {}
    if law.name in PARALLEL:
        return {"kp": k, "ki": k / pid.t_i, "kd": k * pid.t_d, **weight}
    if law.name == "pid_ideal":
        return {"k": k, "t_i": pid.t_i, "t_d": pid.t_d, **weight}
    if law.name == "pid_series":
        return {**_series(k, pid), **weight}
    raise NoProcessError(f"its law is '{law.name}', and this rule is for {LAWS_OF_PID}")


def _series(k: float, pid: IdealPid) -> dict[str, float]:
    """Return the series gains of an ideal PID with real zeros."""
    room = 1.0 - 4.0 * pid.t_d / pid.t_i
    if room < 0.0:
        raise NoProcessError("a series PID has real zeros, and this design has not; use pid_ideal")
    half = 0.5 * (1.0 + sqrt(room))
    return {"k": k * half, "t_i": pid.t_i * half, "t_d": pid.t_d / half}


def adrc_gains(law: Law, design: Bandwidths, control_period: float) -> tuple[dict[str, float], str]:
    """Return the gains of first-order ADRC, and a note on its observer.

    The note is empty unless the control period limits the observer. NoProcessError for another law.
    """
    if law.name != "adrc1":
        raise NoProcessError(f"its law is '{law.name}', and this rule is for adrc1")
    fastest = MAX_BANDWIDTH_PERIODS / control_period
    note = f"The control period allows omega_o up to {fastest:.4g} rad/s." if design.omega_o > fastest else ""
    return {"omega_c": design.omega_c, "omega_o": min(design.omega_o, fastest)}, note
