"""The page of an experiment to fly: its excitations, what it is to tell, and what the vehicle does in simulation."""

from collections.abc import Callable, Mapping

import numpy as np

from tuner.extensions.flight_plans.document import FlightPlanDocument
from tuner.extensions.flight_plans.excitation import UNITS, Excitation, begins
from tuner.extensions.flight_plans.planning import Experiment
from tuner.extensions.flight_plans.words import excitation_table, number_table, peak_table
from tuner.report.charts.chart import Array, Axis, Line, Panel
from tuner.report.charts.look import Look, legend
from tuner.report.charts.paper import Figure, figure_of
from tuner.report.charts.web import grid, page_data
from tuner.report.page import Page, Section, aid, wide_table
from tuner.text.markup import Markup, element, join
from tuner.text.tables import Table
from tuner.text.units import in_degrees

HEIGHT = 3.0
COMMANDED, FLOWN = Look("default"), Look("tuned")
AXES = {"roll": 0, "pitch": 1, "yaw": 2}
AIDS = {
    "excitations": "One after the other, with hover between them.",
    "flown": "Setpoints, and the response in one of the simulated flights.",
    "numbers": "Half-widths of 95 % intervals: before the flight, requested, expected from the information in it, and "
    "obtained by identifying the vehicle from a simulated log.",
    "peaks": "Maxima of all simulated flights, with vehicles from the airframe's uncertainty where it has one.",
}


def figures_of(experiment: Experiment) -> Mapping[str, Callable[[], Figure]]:
    """Return the figures of a plan by name."""
    return {"excitations": lambda: excitation_figure(experiment)}


def flight_plan_page(made: Experiment, document: FlightPlanDocument) -> Page:
    """Return the page."""
    panels = excitation_panels(made)
    targets = [row for row in document.numbers if row.target is not None]
    others = [row for row in document.numbers if row.target is None]
    return Page(
        kind="flight-plan",
        title=f"An experiment to fly with {document.airframe}",
        lead=element("p", document.verdict, class_="lead"),
        opening=join(element("p", note) for note in document.notes),
        sections=[
            Section("excitations", "Excitations", _table("excitations", excitation_table(document))),
            Section(
                "flown", "Setpoints and response", join((aid(AIDS["flown"]), legend(LEGEND), grid(panels, "axis-grid")))
            ),
            Section("numbers", "Parameters to identify", _table("numbers", number_table(targets))),
            Section("others", "The other numbers", _table("others", number_table(others))),
            Section("peaks", "Limits", _table("peaks", peak_table(document))),
        ],
        data=page_data(panels),
    )


LEGEND = (("asked", COMMANDED), ("flown", FLOWN))


def excitation_figure(made: Experiment) -> Figure:
    """Return the chart for paper, a panel for each excitation."""
    return figure_of(excitation_panels(made), 2, HEIGHT, titled=True)


def excitation_panels(made: Experiment) -> list[Panel]:
    """Return a panel for each excitation: what is asked for and what is flown."""
    period = made.task.simulated.system.timing.control_period
    panels = []
    for entry, begin in zip(made.excitations, begins(made.excitations), strict=True):
        first, last = round(begin / period), round((begin + entry.duration) / period)
        time = period * np.arange(float(first), float(last))
        unit, factor = in_degrees(UNITS[entry.quantity])
        lines = [
            Line(name="asked", look=COMMANDED, x=time, y=factor * entry.values(time - begin)),
            Line(name="flown", look=FLOWN, x=time, y=factor * _flown(made, entry)[first:last]),
        ]
        panels.append(
            Panel(f"excitation-{entry.axis}", entry.axis, Axis("time [s]"), Axis(f"{entry.quantity} [{unit}]"), lines)
        )
    return panels


def _flown(made: Experiment, entry: Excitation) -> Array:
    """Return the excited quantity of the first flight (instants,), in SI units."""
    if entry.quantity == "acceleration":
        return made.checked.lift(0) - made.task.simulated.system.vehicle.gravity
    if entry.quantity == "rate":
        return made.checked.rates[0, :, AXES[entry.axis]]
    return made.checked.angles(0)[AXES[entry.axis]]


def _table(key: str, view: Table) -> Markup:
    about = aid(AIDS[key]) if key in AIDS else Markup()
    return join((about, wide_table(view)))
