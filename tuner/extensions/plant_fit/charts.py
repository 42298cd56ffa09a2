"""Charts of a fit."""

from collections.abc import Callable, Mapping
from typing import Any

from tuner.report.charts.paper import Figure


def figures_of(fit: Any) -> Mapping[str, Callable[[], Figure]]:
    """Return the figures of a fit by name."""
    return {}
