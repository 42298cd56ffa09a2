"""Warning of a yaw loop that heavy rotors speed up."""

from math import pi
from typing import NamedTuple

import numpy as np

from objectives.margins.margins import MarginModel
from objectives.margins.period import CHANNELS
from objectives.margins.trim import Trim
from plant.quadrotor.nominal import MAX_CUTOFF, MIN_CUTOFF, yaw_lead, yaw_smoothing
from plant.ties import first_largest
from tuner.study.study import Study

# The lead of the rotors' inertia is felt where it begins below this many times the crossover of yaw: at 3 it still adds 18 deg
# and 5 % of gain. A low-pass on yaw torque up to as many times the lead takes it back.
NEAR = 3.0
# A lead from here on [rad/s] is beyond any yaw loop that the search ranges of the laws can make.
FAR = 150.0
# Cutoffs that are tried, in leads, and the factor of gains that are tried.
CUTOFFS, LOWERED = (1.0, 2.0, NEAR), 0.5
# Gain of phase margin [deg] from which on a change is advised, and peak of the sensitivity that it may not raise beyond.
MIN_RISE, MAX_MS = 1.0, 2.0
# Phase margin [deg] of a yaw loop that the lead does not harm.
HEALTHY = 45.0


class YawMargins(NamedTuple):
    """Margins of yaw, (n,) each; those of a loop that is not stable are 0, 0 and infinite.

    Attributes:
        crossover: Highest gain crossover [rad/s].
        phase: Phase margin [deg].
        ms: Peak of the sensitivity.
    """

    crossover: np.ndarray
    phase: np.ndarray
    ms: np.ndarray


def leading_yaw(study: Study, row: np.ndarray, whose: str) -> list[str]:
    """Warn where rotors' angular momentum makes yaw lead below or near crossover; row: gains row (gains,)."""
    lead, cutoff = yaw_lead(study.system.vehicle), 2.0 * pi * study.options.yaw_torque_cutoff
    if lead > FAR or 0.0 < cutoff <= NEAR * lead:
        return []
    present = yaw_margins(study, row[None])
    crossover = float(present.crossover[0])
    is_healthy = present.phase[0] >= HEALTHY and present.ms[0] <= MAX_MS
    if is_healthy or not (crossover == 0.0 or lead < NEAR * crossover):
        return []
    where = f"crosses over at {crossover:.3g} rad/s" if crossover else "is not stable with it"
    return [
        f"Yaw of {study.airframe.name} leads from {lead:.3g} rad/s on, where accelerating rotors turn the body more than their "
        f"drag does; {whose} {where}. {_advice(study, row, lead, present)}"
    ]


def yaw_margins(study: Study, gains: np.ndarray, cutoff: float | None = None) -> YawMargins:
    """Return the margins of yaw at hover under gains rows (n, gains).

    The signals of sliding terms are at their worst. cutoff: of the low-pass on yaw torque [Hz], by default the study's.
    """
    system = study.system
    knowledge = system.nominal
    if cutoff is not None:
        knowledge = knowledge._replace(yaw_smoothing=yaw_smoothing(cutoff, system.timing.control_period))
    # Yaw is a loop by itself at hover: how often the position loops step does not matter to it.
    model = MarginModel(system.cascade.at_one_rate, knowledge, system.timing, system.vehicle, Trim(hold=False))
    margins, yaw = model.evaluate(np.asarray(gains, dtype=float)), CHANNELS.index("yaw")
    return YawMargins(
        margins.crossover.value[:, yaw], np.degrees(margins.phase.value[:, yaw]), margins.sensitivity.value[:, yaw]
    )


def _advice(study: Study, row: np.ndarray, lead: float, present: YawMargins) -> str:
    """Return the best of the changes that were tried, in a sentence."""
    now = f"{present.phase[0]:.3g} deg"
    wanted = np.clip(lead / (2.0 * pi) * np.array(CUTOFFS), MIN_CUTOFF, MAX_CUTOFF).tolist()
    cutoffs = list(dict.fromkeys(float(f"{each:.2g}") for each in wanted))
    tried = [yaw_margins(study, row[None], cutoff) for cutoff in cutoffs]
    best = _better(present, np.array([each.phase[0] for each in tried]), np.array([each.ms[0] for each in tried]))
    if best is not None:
        return (
            f"Set controller.yaw_torque_cutoff = {cutoffs[best]:g} (Hz): its phase margin is then "
            f"{tried[best].phase[0]:.3g} deg (now {now})."
        )
    gains = [gain for gain in study.system.gains if gain.axis == "yaw" and not gain.info.airframe and row[gain.column]]
    rows = np.repeat(row[None], len(gains), axis=0)
    for i, gain in enumerate(gains):
        rows[i, gain.column] *= LOWERED
    if gains:
        lowered = yaw_margins(study, rows)
        best = _better(present, lowered.phase, lowered.ms)
        if best is not None:
            return f"Half of {gains[best].address} gives a phase margin of {lowered.phase[best]:.3g} deg (now {now})."
    return (
        f"A yaw_torque_cutoff of {', '.join(f'{each:g}' for each in cutoffs)} Hz and the half of each yaw gain were tried: none "
        f"raises its phase margin of {now}."
    )


def _better(present: YawMargins, phase: np.ndarray, ms: np.ndarray) -> int | None:
    """Return the index of the largest phase margin (n,) worth a change."""
    allowed = (phase >= present.phase[0] + MIN_RISE) & (ms <= max(MAX_MS, float(present.ms[0])))
    return first_largest(np.where(allowed, phase, -np.inf)) if allowed.any() else None
