"""Figures of results as matplotlib objects, made without pyplot: the same as in the folders, in the same style."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from plant.errors import InputError, UnknownNameError
from tuner.analysis.margins.readings import Loops
from tuner.documents.comparison import ComparedFolder
from tuner.documents.tuning import TuningFolder
from tuner.extension import added, load
from tuner.report.charts.paper import Figure, drawn, style
from tuner.report.comparison.figures import FIGURES, values_figure
from tuner.report.figures import flown_figure, front_figure, progress_figure, scenario_figures
from tuner.report.margin_figures import bode_figure, loops_of, nichols_figure, nyquist_figure
from tuner.report.sheets import added_sheets

Drawers = Mapping[str, Callable[[], Figure | None]]
"""Figures by name, each drawn when it is called; None where there is no data for it."""

LOOPS = {"bode": bode_figure, "nyquist": nyquist_figure, "nichols": nichols_figure}


@dataclass(frozen=True)
class Figures:
    """Figures of some results; drawers: by name."""

    drawers: Drawers

    @property
    def names(self) -> list[str]:
        """Names of the figures."""
        return list(self.drawers)

    def draw(self, name: str) -> Figure:
        """Return a figure; UnknownNameError where there is none of that name, InputError where there is no data for it."""
        if name not in self.drawers:
            raise UnknownNameError("figure", name, self.drawers)
        with style():
            figure = self.drawers[name]()
        if figure is None:
            raise InputError(f"these results hold nothing for the figure '{name}'")
        return figure


def of_tuning(results: TuningFolder) -> Drawers:
    """Return the figures of a tuning run."""
    over_flights = scenario_figures(results)
    more: Drawers = {name: lambda sheet=sheet: drawn(sheet) for name, sheet in added_sheets(results).items()}
    return {
        "front": lambda: front_figure(results),
        "progress": lambda: progress_figure(results),
        **more,
        **over_flights,
    }


def of_comparison(compared: ComparedFolder[Any]) -> Drawers:
    """Return the figures of contenders on the same flights."""
    return {name: lambda draw=draw: draw(compared) for name, draw in FIGURES.items()}


def of_margins(subject: Loops) -> Drawers:
    """Return the figures of the loops of a controller."""
    loops = loops_of(subject)
    return {name: lambda draw=draw: draw(subject, loops) for name, draw in LOOPS.items()}


DRAWN: dict[str, Callable[..., Drawers]] = {
    "tuning": of_tuning,
    "comparison": lambda results: {**of_comparison(results), "values": lambda: values_figure(results)},
    "margins": of_margins,
    "flights": lambda responses, scenario: {"responses": lambda: flown_figure(responses, scenario)},
}
"""Kind of results of the core -> their figures; those of extensions are in their records."""


def figures_of(kind: str, *data: Any) -> Figures:
    """Return the figures of a kind of results."""
    drawn_of = DRAWN[kind] if kind in DRAWN else load(added("figures")[kind])
    return Figures(drawn_of(*data))
