"""Sheets of the figures for a paper: front, responses and progress of a results folder, or the responses of one controller."""

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tuner.documents.tables import Fan
from tuner.documents.tuning import DEFAULT, TUNED, TuningFolder
from tuner.extension import objects
from tuner.report.charts import fans
from tuner.report.charts.chart import Axis, Mark, Panel
from tuner.report.charts.front import front_panels
from tuner.report.charts.look import role_look
from tuner.report.charts.progress import progress_panels
from tuner.report.charts.sheet import WIDTH, FigureSpec
from tuner.report.charts.spectra import spectrum_mark, spectrum_panel
from tuner.text.units import in_degrees

if TYPE_CHECKING:
    from tuner.analysis.responses import Responses

COLUMNS, ROW = 4, 1.7
ADDED_COLUMNS = 2
"""Columns of figures of extensions."""
ADDED_HEIGHT = 2.4
"""Height of figures of extensions."""


def search_sheets(results: TuningFolder) -> dict[str, FigureSpec]:
    """Return the sheets of search and front, by names of figures."""
    return {"front": front_sheet(results), "progress": progress_sheet(results)} | added_sheets(results)


def scenario_sheets(results: TuningFolder) -> dict[str, Callable[[], FigureSpec]]:
    """Return makers of the sheets of responses and spectra in every scenario, by names of figures."""
    responses = {
        name: lambda scenario=scenario: response_sheet(results, scenario)
        for name, scenario in scenario_names("responses", results.scenarios).items()
    }
    spectra = {
        name: lambda scenario=scenario: spectrum_sheet(results, scenario)
        for name, scenario in scenario_names("spectrum", [entry.scenario for entry in results.spectra]).items()
    }
    return responses | spectra


def scenario_names(stem: str, scenarios: Sequence[str]) -> dict[str, str]:
    """Return scenarios by the names of their figures: the stem alone, or with the scenario's name, made safe and unique."""
    different = list(dict.fromkeys(scenarios))
    if len(different) == 1:
        return {stem: different[0]}
    names: dict[str, str] = {}
    for i, scenario in enumerate(different):
        name = f"{stem}-" + (re.sub(r"[^A-Za-z0-9]+", "-", scenario).strip("-") or str(i))
        names[f"{name}-{i}" if name in names else name] = scenario
    return names


def front_sheet(results: TuningFolder) -> FigureSpec:
    """Return the front with a panel for each pair of objectives; of one objective, the points in order."""
    panels = front_panels(results)
    if len(panels) == 1:
        height = 0.9 + 0.17 * len(results.held_out_front.points) if panels[0].rows else 3.2
        return FigureSpec(panels, 1, height, 0.62 * WIDTH)
    return FigureSpec(panels, min(len(panels), 3), 2.4)


def progress_sheet(results: TuningFolder) -> FigureSpec:
    """Return hypervolume and share of feasible candidates by generation, side by side."""
    volume, feasible = progress_panels(results.progress)[:2]
    panels = [
        replace(volume, y=Axis("hypervolume [share of box]")),
        replace(feasible, y=feasible.y._replace(title="feasible candidates [%]")),
    ]
    return FigureSpec(panels, 2, 2.2, legend=False)


def added_panels(results: TuningFolder) -> dict[str, list[Panel]]:
    """Return the panels of extensions by names of figures."""
    panels = {name: panels_of(results) for name, panels_of in objects("panels").items()}
    return {name: made for name, made in panels.items() if made}


def added_sheets(results: TuningFolder) -> dict[str, FigureSpec]:
    """Return the sheets of extensions by names of figures."""
    columns = {name: min(len(panels), ADDED_COLUMNS) for name, panels in added_panels(results).items()}
    return {
        name: FigureSpec(panels, columns[name], ADDED_HEIGHT, WIDTH * columns[name] / ADDED_COLUMNS, titled=True)
        for name, panels in added_panels(results).items()
    }


def response_sheet(results: TuningFolder, scenario: str) -> FigureSpec:
    """Return the responses in a scenario, tuned over default, a panel for each axis and one for rotor 1."""
    recorded = [
        fan
        for fan in results.fans
        if fan.scenario == scenario and results.held_out_front.role(fan.point) in (DEFAULT, TUNED)
    ]
    recorded.sort(key=lambda fan: results.held_out_front.role(fan.point) == TUNED)
    names = {
        fan.point: results.shown_as if results.held_out_front.role(fan.point) == TUNED else DEFAULT for fan in recorded
    }
    roles = {fan.point: results.held_out_front.role(fan.point) for fan in recorded}
    panels = _panels(recorded, names, roles)
    return FigureSpec(panels, min(len(panels), COLUMNS), ROW)


def spectrum_sheet(results: TuningFolder, scenario: str) -> FigureSpec:
    """Return the spectra of the commands in a scenario, of default and tuned gains."""
    spectra = [entry for entry in results.spectra if entry.scenario == scenario]
    roles = [results.held_out_front.role(entry.point) for entry in spectra]
    marks = [
        spectrum_mark(entry, role_look(role), results.shown_as if role == TUNED else DEFAULT)
        for entry, role in zip(spectra, roles, strict=True)
    ]
    return FigureSpec([replace(spectrum_panel(marks), title="")], 1, 2.4, 0.62 * WIDTH)


def flown_sheet(responses: "Responses", scenario: str) -> FigureSpec:
    """Return the fans of one controller, a panel for each axis and one for rotor 1."""
    names = {TUNED: f"{len(responses.actual)} flights"}
    panels = _panels(fans_of(responses, scenario), names, {})
    return FigureSpec(panels, min(len(panels), COLUMNS), ROW, note=f"scenario {scenario}")


def fans_of(responses: "Responses", scenario: str) -> list[Fan]:
    """Return the fans of recorded responses in shown units."""
    series = (responses.reference.mean(axis=0), *responses.fans())
    bands = []
    for i, (signal, unit) in enumerate(zip(responses.signals, responses.units, strict=True)):
        shown, factor = in_degrees(unit)
        setpoint, low, median, high = (np.asarray(part[:, i]) * factor for part in series)
        bands.append(Fan(TUNED, scenario, signal, shown, responses.time, setpoint, low, median, high))
    return bands


def _panels(recorded: Sequence[Fan], names: dict[str, str], roles: dict[str, str]) -> list[Panel]:
    """Return a panel for each signal that is shown on paper; references only where all fans have the same."""
    panels = []
    for signal in fans.shown_signals([fan.signal for fan in recorded]):
        group = [fan for fan in recorded if fan.signal == signal]
        marks = [mark for fan in group for mark in _fan(fan, names, roles)]
        marks += fans.reference(group[0].time, group[0].reference, {}) if fans.agree(group) else []
        time = group[0].time
        x = Axis("time [s]", float(time[0]), float(time[-1]))
        panels.append(Panel(signal, "", x, Axis(fans.title(signal, group[0].unit)), marks))
    return panels


def _fan(fan: Fan, names: dict[str, str], roles: dict[str, str]) -> list[Mark]:
    look, name = role_look(roles.get(fan.point, TUNED)), f"{names[fan.point]}: median and 5–95 %"
    return fans.fan_marks(replace(fan, worst=None), look, name, {})
