"""Axes that the tests of designs share, with room around the gains so that only the requirement under test is felt."""

from dataclasses import replace
from typing import Any

from objectives.design import DesignAxis, DesignRequirements
from objectives.linear_axis.channel_model import RotorLag
from plant.law_registry import LAWS
from plant.laws.law import Law, Span

# 20 ms of lag and 4 ms of dead time.
ROTORS = RotorLag(0.02, 0.004, lag_aware=True, order=2)
# Nothing but the peaks counts.
FREE = DesignRequirements(speed=0.0, damping=50.0, noise=1e6, attitude_step=1e-6)


def roomy(name: str, **spans: tuple[float, float]) -> Law:
    """A law whose attitude gains may be searched in the given ranges."""
    law = LAWS[name]
    gains = [
        replace(gain, attitude=Span(gain.attitude.default, *spans[gain.name])) if gain.name in spans else gain
        for gain in law.gains
    ]
    return replace(law, gains=tuple(gains))


def axis(
    law: Law, actuator: Any = ROTORS, observed: bool = False, period: float = 0.001, authority: float = 250.0
) -> DesignAxis:
    return DesignAxis(law, "attitude", actuator, observed, period, authority)
