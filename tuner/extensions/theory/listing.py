"""Rows of `tuner list theorems`."""

from tuner.api.catalogue import Rows
from tuner.extensions.theory.theorems import THEOREMS


def theorems() -> Rows:
    """Results of theory that a [[guarantee]] may ask for."""
    return [
        {
            "theorem": name,
            "title": theorem.title,
            "unit": theorem.unit.format(y="rad|m"),
            "limit": theorem.sense,
            "quantity": theorem.quantity,
            "laws": ", ".join(theorem.laws),
            "rates": "measured" if theorem.measured_rate else "any",
            "assumes": theorem.assumes,
            "source": theorem.source,
        }
        for name, theorem in THEOREMS.items()
    ]
