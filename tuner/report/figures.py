"""Figures for a paper: front, responses and progress of a results folder, or the responses of one controller."""

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from plant.errors import InputError
from tuner.documents.tables import Fan
from tuner.documents.tuning import DEFAULT, TUNED, TuningFolder
from tuner.report.charts import fans
from tuner.report.charts.chart import Axis, Mark, Panel
from tuner.report.charts.front import front_panels
from tuner.report.charts.look import role_look
from tuner.report.charts.paper import DPI, WIDTH, Figure, figure_of, grid, printed, style
from tuner.report.charts.progress import progress_panels
from tuner.report.charts.spectra import spectrum_mark, spectrum_panel
from tuner.store.folder import put_together
from tuner.text.units import in_degrees

if TYPE_CHECKING:
    from tuner.analysis.responses import Responses

ENDINGS = (".png", ".pdf", ".svg")
COLUMNS, ROW = 4, 1.7


def write_all(folder: Path) -> list[Path]:
    """Write every figure that the folder has data for and return the files."""
    return put_together(folder, draw_all(folder))


def make_ready() -> None:
    """Import what reads tables and documents, and draw a word, so that fonts are read: a second that `draw_all` takes less."""
    # A table's numbers are cast by the former.
    import pyarrow.compute
    import pyarrow.parquet  # noqa: F401

    TuningFolder.model.model_rebuild()
    with style():
        printed(grid(1, 1, 1.0)[0])


def draw_all(folder: Path, wait: Callable[[], object] = lambda: None) -> dict[str, bytes]:
    """Return every figure that the folder has data for, by its name in the folder.

    wait: called before the folder is opened, when it must hold all but responses, and again before they are read.
    """
    wait()
    results = TuningFolder(folder)
    with style():
        files = files_of("front", front_figure(results)) | files_of("progress", progress_figure(results))
        wait()
        for name, draw in scenario_figures(results).items():
            files |= files_of(name, draw())
    return files


def files_of(name: str, figure: Figure) -> dict[str, bytes]:
    """Return the files of a figure by their names in the folder."""
    return {f"figures/{name}{ending}": content for ending, content in printed(figure).items()}


def scenario_figures(results: TuningFolder) -> dict[str, Callable[[], Figure]]:
    """Return what draws the responses, and the spectra if there are any, in every scenario, by names of figures."""
    responses = {
        name: lambda scenario=scenario: response_figure(results, scenario)
        for name, scenario in scenario_names("responses", results.scenarios).items()
    }
    spectra = {
        name: lambda scenario=scenario: spectrum_figure(results, scenario)
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


def front_figure(results: TuningFolder) -> Figure:
    """Return the front with a panel for each pair of objectives; of one objective, the points in order."""
    panels = front_panels(results)
    if len(panels) == 1:
        height = 0.9 + 0.17 * len(results.front.points) if panels[0].rows else 3.2
        return figure_of(panels, 1, height, 0.62 * WIDTH)
    return figure_of(panels, min(len(panels), 3), 2.4)


def progress_figure(results: TuningFolder) -> Figure:
    """Return hypervolume and share of feasible candidates by generation, side by side."""
    volume, feasible = progress_panels(results.history)[:2]
    panels = [
        replace(volume, y=Axis("hypervolume [share of box]")),
        replace(feasible, y=feasible.y._replace(title="feasible candidates [%]")),
    ]
    return figure_of(panels, 2, 2.2, legend=False)


def response_figure(results: TuningFolder, scenario: str) -> Figure:
    """Return the responses in a scenario, tuned over default, a panel for each axis and one for rotor 1."""
    known = [
        fan for fan in results.fans if fan.scenario == scenario and results.front.role(fan.point) in (DEFAULT, TUNED)
    ]
    known.sort(key=lambda fan: results.front.role(fan.point) == TUNED)
    names = {fan.point: results.shown_as if results.front.role(fan.point) == TUNED else DEFAULT for fan in known}
    roles = {fan.point: results.front.role(fan.point) for fan in known}
    panels = _panels(known, names, roles)
    return figure_of(panels, min(len(panels), COLUMNS), ROW)


def spectrum_figure(results: TuningFolder, scenario: str) -> Figure:
    """Return the spectra of the commands in a scenario, of default and tuned gains."""
    known = [entry for entry in results.spectra if entry.scenario == scenario]
    roles = [results.front.role(entry.point) for entry in known]
    marks = [
        spectrum_mark(entry, role_look(role), results.shown_as if role == TUNED else DEFAULT)
        for entry, role in zip(known, roles, strict=True)
    ]
    return figure_of([replace(spectrum_panel(marks), title="")], 1, 2.4, 0.62 * WIDTH)


def write_responses(responses: "Responses", scenario: str, file: Path) -> None:
    """Write the fans of one controller; the ending of the file says the format. InputError where it cannot be."""
    if file.suffix.lower() not in ENDINGS:
        raise InputError(f"given '{file}'; allowed endings: {', '.join(ENDINGS)}", key="--plot")
    with style():
        figure = flown_figure(responses, scenario)
        try:
            figure.savefig(file, dpi=DPI)
        except OSError as error:
            raise InputError(f"{file} cannot be written ({error.strerror})", key="--plot") from error


def flown_figure(responses: "Responses", scenario: str) -> Figure:
    """Return the fans of one controller, a panel for each axis and one for rotor 1."""
    names = {TUNED: f"{len(responses.actual)} flights"}
    panels = _panels(fans_of(responses, scenario), names, {})
    return figure_of(panels, min(len(panels), COLUMNS), ROW, note=f"scenario {scenario}")


def fans_of(responses: "Responses", scenario: str) -> list[Fan]:
    """Return the fans of recorded responses in shown units."""
    reference = responses.reference.mean(axis=0)
    found = []
    for i, (signal, unit) in enumerate(zip(responses.signals, responses.units, strict=True)):
        shown, factor = in_degrees(unit)
        asked, low, median, high = (np.asarray(part[:, i]) * factor for part in (reference, *responses.fans()))
        found.append(Fan(TUNED, scenario, signal, shown, responses.time, asked, low, median, high))
    return found


def _panels(known: Sequence[Fan], names: dict[str, str], roles: dict[str, str]) -> list[Panel]:
    """Return a panel for each signal that is shown on paper; references only where all fans have the same."""
    panels = []
    for signal in fans.shown_signals([fan.signal for fan in known]):
        group = [fan for fan in known if fan.signal == signal]
        marks = [mark for fan in group for mark in _fan(fan, names, roles)]
        marks += fans.reference(group[0].time, group[0].reference, {}) if fans.agree(group) else []
        time = group[0].time
        x = Axis("time [s]", float(time[0]), float(time[-1]))
        panels.append(Panel(signal, "", x, Axis(fans.title(signal, group[0].unit)), marks))
    return panels


def _fan(fan: Fan, names: dict[str, str], roles: dict[str, str]) -> list[Mark]:
    look, name = role_look(roles.get(fan.point, TUNED)), f"{names[fan.point]}: median and 5–95 %"
    return fans.fan_marks(replace(fan, worst=None), look, name, {})
