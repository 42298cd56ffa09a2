"""A certificate: a number that was proved about one axis of a controller, or the reason why none was found."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from objectives.linear_axis.channel_model import MODELLED, AxisLoop, TiltLoop


@dataclass(frozen=True)
class Certificate:
    """A proved number.

    Attributes:
        value: Number in `unit`, None if nothing was proved.
        unit: Unit of the value.
        verified: Whether eigenvalues confirmed the matrix inequalities behind it after the solver had returned; a value
            is given only then.
        why: One sentence, what was proved or what stood in the way.
        data: Basis of the proof, such as the matrix P, by name.
    """

    value: float | None
    unit: str
    verified: bool
    why: str
    data: Mapping[str, Any] = field(default_factory=dict)


def inconclusive(unit: str, why: str, **data: Any) -> Certificate:
    """Return a certificate of nothing. It says nothing against the controller: the methods are sufficient, not necessary."""
    return Certificate(None, unit, False, why, data)


@dataclass(frozen=True)
class CertificateInfo:
    """An entry of the registry.

    laws: names of the laws it can be asked about. run(axis, **settings) -> Certificate: never raises for want of a proof.
    """

    name: str
    title: str
    source: str
    laws: frozenset[str]
    run: Callable[..., Certificate]

    def applies_to(self, axis: AxisLoop) -> bool:
        """Return True if it can be asked about this axis: by its law, and by the attitude loop it may act through."""
        inner = axis.actuator.attitude if isinstance(axis.actuator, TiltLoop) else None
        return axis.law in self.laws and (inner is None or inner.law in MODELLED)
