"""What all interactive figures share: plain dictionaries for plotly.js, colours by name, long arrays stored once.

Two kinds of text stand for something else until page.js draws: "@name" or "@name/0.3" is the colour --name of page.css,
with an opacity, so that a figure follows the colour scheme; "#name" is the array of that name in `Charts.shared`.
`meta` of a trace says when it is visible: "layer" (a checkbox), "point" and "scenario" (choices above the responses).
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from html import escape
from typing import Any, NamedTuple

import numpy as np

from tuner.text.numbers import compact

Trace = dict[str, Any]


class Panel(NamedTuple):
    """Where a figure goes: the id of its element, its form (a class of page.css) and its heading."""

    name: str
    form: str
    title: str


@dataclass
class Charts:
    """The figures of a page: charts, id -> traces and layout; shared, name -> array."""

    charts: dict[str, dict[str, Any]] = field(default_factory=dict)
    shared: dict[str, list[Any]] = field(default_factory=dict)

    def add(self, name: str, traces: list[Trace], layout: dict[str, Any]) -> None:
        """Add a figure under the id of the element it is drawn in."""
        assert name not in self.charts, f"two figures are called {name}"
        self.charts[name] = {"traces": traces, "layout": layout}

    def share(self, name: str, values: Iterable[Any]) -> str:
        """Store an array once and return what stands for it in a trace."""
        self.shared[name] = list(values)
        return f"#{name}"


def listed(values: np.ndarray) -> list[float | None]:
    """Return an array (n,) for a trace: five significant digits, None where it is not finite."""
    return [compact(value) for value in values.tolist()]


def axis(title: str, **more: Any) -> dict[str, Any]:
    """Return a plain axis; more: any attribute of a plotly axis."""
    return {
        "title": {"text": escape(title, quote=False), "standoff": 6},
        "gridcolor": "@grid",
        "linecolor": "@line",
        "zeroline": False,
        "automargin": True,
        "nticks": 6,
        **more,
    }


def layout(x: dict[str, Any], y: dict[str, Any], **more: Any) -> dict[str, Any]:
    """Return the layout of a figure with two axes; more: any attribute of a plotly layout."""
    return {
        **base(),
        "xaxis": x,
        "yaxis": y,
        "margin": {"l": 8, "r": 12, "t": 10, "b": 8},
        **more,
    }


def base() -> dict[str, Any]:
    """Return what every layout has: text and hover labels in the colours of the page, no background, no legend."""
    return {
        "paper_bgcolor": "rgba(0,0,0,0)",
        "plot_bgcolor": "rgba(0,0,0,0)",
        "font": {"color": "@muted", "size": 12},
        "hoverlabel": {
            "bgcolor": "@surface",
            "bordercolor": "@line",
            "font": {"color": "@ink", "size": 12},
            "align": "left",
        },
        "showlegend": False,
        "hovermode": "closest",
    }
