"""Theorems as numbers that a study can require of its gains: `THEOREMS` by name."""

from tuner.extensions.theory.theorems.levant import LEVANT
from tuner.extensions.theory.theorems.moreno_osorio import MORENO_OSORIO
from tuner.extensions.theory.theorems.observer_error import DISTURBANCE, RATE, VALUE
from tuner.extensions.theory.theorems.paper22 import PAPER22
from tuner.extensions.theory.theorems.seeber_horn import SEEBER_HORN
from tuner.extensions.theory.theorems.theorem import Setting, Theorem
from tuner.extensions.theory.theorems.ultimate_bound import ULTIMATE_ERROR
from tuner.extensions.theory.theorems.worst_case import WORST_CASE

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
