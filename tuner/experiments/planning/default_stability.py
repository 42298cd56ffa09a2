"""An unstable default before anything flies: its loops, its pole, and whether the other sign of b0 would be stable."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from objectives.margins.loop_margins import LoopMargins
from plant.errors import InputError
from tuner.store.document import DocumentPart
from tuner.study.margins import nominal_margins
from tuner.study.plant_margins import plant_margins
from tuner.study.plant_study import PlantStudy
from tuner.study.study import Study
from tuner.study.trim import hover_of

EDGE = 1e-10
"""Growth over a control period up to which a pole is at the edge of stability: eigenvalues are rounded by some 1e-13."""


class ReversedGain(DocumentPart):
    """A channel with the b0 that makes its loop stable."""

    channel: str
    b0: float


class UnstableLoop(DocumentPart):
    """Loops that are not stable under the default.

    Attributes:
        channels: Channels that are coupled with each other.
        growth: Real part of the fastest growing pole [1/s].
        frequency: Its imaginary part [rad/s].
        other_sign: Channel of a plant that the other sign of b0 makes stable, null where there is none.
        tried: Values of b0 that were tried, by channel.
    """

    channels: list[str]
    growth: float
    frequency: float
    other_sign: ReversedGain | None = None
    tried: dict[str, float] = {}


def unstable_loops_at_hover(study: Study) -> list[UnstableLoop]:
    """Return the unstable loops of a quadrotor's default at hover."""
    system = study.system
    (hover,) = hover_of([entry.spec for entry in study.scenarios], system.timing)
    model = nominal_margins(
        system.cascade, system.nominal, system.timing, system.vehicle, hover.trim, system.cascade.position_every > 1
    )
    return _unstable(model, study.default_row)


def unstable_loops_of_plant(study: PlantStudy) -> list[UnstableLoop]:
    """Return the unstable loops of a plant's default at rest.

    There are none of a plant whose margins are not known.
    """
    # The slope of an FMU takes calls of it, which only a study that limits margins makes.
    if not study.system.has_equations and not study.screens:
        return []
    try:
        loops = _unstable(study.margin_model(), study.default_row)
        return [_with_other_sign(study, loop) for loop in loops]
    except InputError:
        return []


def _unstable(model: LoopMargins, row: np.ndarray) -> list[UnstableLoop]:
    return [
        UnstableLoop(channels=list(channels), growth=pole.real, frequency=abs(pole.imag))
        for channels, pole in model.slowest_poles(row)
        if pole.real * model.control_period > EDGE
    ]


def _with_other_sign(study: PlantStudy, loop: UnstableLoop) -> UnstableLoop:
    """Return an unstable loop of a plant with the other signs tried."""
    system, tried = study.system, dict[str, float]()
    for name in loop.channels:
        channels = tuple(replace(each, b0=-each.b0) if each.name == name else each for each in system.plan.channels)
        tried[name] = -system.plan.channel(name).b0
        turned = replace(system, plan=replace(system.plan, channels=channels))
        still = {
            each
            for other in _unstable(plant_margins(turned, study.space), study.default_row)
            for each in other.channels
        }
        if still.isdisjoint(loop.channels):
            stable = ReversedGain(channel=name, b0=tried[name])
            return loop.model_copy(update={"other_sign": stable, "tried": tried})
    return loop.model_copy(update={"tried": tried})


def instability_texts(loops: Sequence[UnstableLoop], kind: str) -> list[str]:
    """Return unstable loops in sentences; kind: what a loop is called, "loop" or "channel"."""
    return [_text(loop, kind) for loop in loops]


def _text(loop: UnstableLoop, kind: str) -> str:
    named = f"{kind}{'s' if len(loop.channels) > 1 else ''} {', '.join(loop.channels)}"
    pole = f"{loop.growth:.3g} 1/s"
    if loop.frequency > 0.0:
        pole = f"{loop.growth:.3g} +- {loop.frequency:.3g}i 1/s"
    text = f"The default is not stable in {named}: a pole at {pole}, so that errors grow e-fold every {1.0 / loop.growth:.3g} s."
    if loop.other_sign is not None:
        return f"{text} With b0 = {loop.other_sign.b0:g} in channel {loop.other_sign.channel} it is stable."
    if loop.tried:
        values = ", ".join(f"b0 = {value:g} in channel {name}" for name, value in loop.tried.items())
        return f"{text} The other sign ({values}) is not stable either."
    return text
