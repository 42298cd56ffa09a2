"""Theorems as numbers that a study can require of its gains: `THEOREMS` by name."""

from objectives.theory.levant import LEVANT
from objectives.theory.moreno_osorio import MORENO_OSORIO
from objectives.theory.observer_error import DISTURBANCE, RATE, VALUE
from objectives.theory.paper22 import PAPER22
from objectives.theory.seeber_horn import SEEBER_HORN
from objectives.theory.theorem import Setting, Theorem
from objectives.theory.ultimate_bound import ULTIMATE_ERROR
from objectives.theory.worst_case import WORST_CASE

__all__ = ["THEOREMS", "Setting", "Theorem"]

THEOREMS: dict[str, Theorem] = {
    entry.name: entry
    for entry in (
        VALUE,
        RATE,
        DISTURBANCE,
        ULTIMATE_ERROR,
        LEVANT,
        SEEBER_HORN,
        PAPER22,
        MORENO_OSORIO,
        WORST_CASE,
    )
}
