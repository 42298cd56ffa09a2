"""Methods of `tuner design`: a rule applied to every channel of a plant."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from objectives.design.plant_design import ChannelDesign
from plant.model.plan import Channel
from tuner.api.designing import Proposal
from tuner.extensions.design_rules import rules, state_feedback
from tuner.extensions.design_rules.gains import adrc_gains, pid_gains
from tuner.extensions.design_rules.peaks import judged
from tuner.extensions.design_rules.process import NoProcessError, Process, process_of
from tuner.gains.ranges import check_value
from tuner.study.plant_study import PlantStudy

Array = np.ndarray
Rule = Callable[[Process, float | None], rules.IdealPid | rules.Bandwidths]
OLD_RULE = (
    "Ziegler-Nichols aims at a quarter-amplitude decay: expect 50 % overshoot and little margin. Take it as a start for a "
    "search, or use simc or amigo."
)
# Factor by which the b0 of a study may differ from the rule's before a note says so.
CLOSE = 1.5
# Smallest damping ratio of poles that a lag approximates: at 0.7 a step overshoots by 5 %.
MIN_DAMPING = 0.7


@dataclass(frozen=True)
class Applied:
    """Gains of a channel by name, and a note."""

    gains: dict[str, float]
    note: str


def propose(rule: Rule, warning: str, study: PlantStudy, time: float | None) -> Proposal:
    """Return the gains that a rule has for every channel.

    time: closed-loop time [s], None for the rule's own.
    """
    row = np.array(study.default_row, dtype=float)
    refused, notes = dict[str, ChannelDesign](), [warning] if warning else []
    for channel in study.system.plan.channels:
        try:
            design = _applied(rule, study, channel, time)
        except NoProcessError as error:
            refused[channel.name] = ChannelDesign(False, str(error))
            continue
        row = _with(study, row, channel, design.gains)
        notes.append(design.note)
    names = study.system.plan.names
    return Proposal(row, refused if len(refused) == len(names) else judged(study, row) | refused, notes)


def _applied(rule: Rule, study: PlantStudy, channel: Channel, time: float | None) -> Applied:
    process = process_of(study.system, channel)
    design = rule(process, time)
    if isinstance(design, rules.IdealPid):
        return Applied(pid_gains(channel.law, design, channel.b0), _about(channel, process, design.model, design.time))
    gains, limited = adrc_gains(channel.law, design, channel.every * study.system.timing.control_period)
    ratio = channel.b0 / design.b0
    notes = [_about(channel, process, "", design.time), *([limited] if limited else [])]
    if not 1.0 / CLOSE < ratio < CLOSE:
        notes.append(f"The rule has b0 = {design.b0:.4g}, the study b0 = {channel.b0:.4g}.")
    return Applied(gains, " ".join(notes))


def _about(channel: Channel, process: Process, model: str, time: float | None) -> str:
    """Return a note on the process and closed-loop time."""
    taken = f"gain {process.gain:.4g}, {model}" if model else process.words
    aim = "" if time is None else f"; closed-loop time {time:.4g} s (--time)"
    return f"{channel.name}: taken for {taken}{aim}.{damping_warning(process.damping)}"


def damping_warning(damping: float) -> str:
    """Return a warning for poles that a lag does not approximate."""
    if damping >= MIN_DAMPING:
        return ""
    return (
        f" Its poles swing with a damping ratio of {damping:.2g}, and rules take lags: look at the margins, or design with the "
        "law pid without --method."
    )


def _with(study: PlantStudy, row: Array, channel: Channel, gains: dict[str, float]) -> Array:
    """Return a gains row with those of a channel; InputError for a value that a gain cannot have."""
    row = row.copy()
    for gain in study.system.gains:
        if gain.axis == channel.name and gain.info.name in gains:
            value = gains[gain.info.name]
            check_value(gain.address, gain, value, study.system.timing.control_period, "the rule gives")
            row[gain.column] = value
    return row


SIMC = partial(propose, rules.simc, "")
LAMBDA = partial(propose, rules.lambda_, "")
AMIGO = partial(propose, rules.amigo, "")
ZIEGLER_NICHOLS = partial(propose, rules.ziegler_nichols, OLD_RULE)
HERBST = partial(propose, rules.herbst, "")
LQR = partial(state_feedback.propose, state_feedback.lqr)
POLES = partial(state_feedback.propose, state_feedback.poles)
