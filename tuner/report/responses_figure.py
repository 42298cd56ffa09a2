"""Monte Carlo fans for a paper: default and tuned of a results folder, or the flights of one controller."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from plant.errors import InputError
from tuner.documents.results import DEFAULT, TUNED, Fan, Results
from tuner.report.figure_style import COLOURS, DASHES, DPI, grid, legend_above, style
from tuner.report.response_charts import is_rotor, title
from tuner.text.units import in_degrees

if TYPE_CHECKING:
    from tuner.analysis.responses import Responses

ENDINGS = (".png", ".pdf", ".svg")
COLUMNS, ROW = 4, 1.7


def response_figure(results: Results, scenario: str) -> Figure:
    """Return the responses in a scenario, tuned over default, a panel for each axis and one for rotor 1."""
    shown = (DEFAULT, TUNED)
    fans = [fan for fan in results.fans if fan.scenario == scenario and results.front.role(fan.point) in shown]
    groups = [[fan for fan in fans if fan.signal == signal] for signal in shown_signals(fans)]
    figure, axes = grid(len(groups), COLUMNS, ROW)
    for ax, group in zip(axes, groups, strict=True):
        for fan in sorted(group, key=lambda fan: results.front.role(fan.point) == TUNED):
            role = results.front.role(fan.point)
            name = results.shown_as if role == TUNED else role
            draw_fan(ax, fan, role, f"{name}: median and 5–95 %")
        draw_references(ax, group)
        _label(ax, group[0])
    legend_above(figure, axes[0])
    return figure


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
    fans = fans_of(responses, scenario)
    by_signal = {fan.signal: fan for fan in fans}
    shown = shown_signals(fans)
    figure, axes = grid(len(shown), COLUMNS, ROW)
    for ax, fan in zip(axes, [by_signal[signal] for signal in shown], strict=True):
        draw_fan(ax, fan, TUNED, f"median and 5–95 % of {len(responses.actual)} flights")
        draw_references(ax, [fan])
        _label(ax, fan)
    legend_above(figure, axes[0])
    figure.suptitle(scenario)
    return figure


def fans_of(responses: "Responses", scenario: str) -> list[Fan]:
    """Return the fans of recorded responses in shown units."""
    from tuner.analysis.responses import SIGNALS, UNITS

    reference = responses.reference.mean(axis=0)
    fans = []
    for i, (signal, unit) in enumerate(zip(SIGNALS, UNITS, strict=True)):
        shown, factor = in_degrees(unit)
        asked, low, median, high = (np.asarray(part[:, i]) * factor for part in (reference, *responses.fans()))
        fans.append(Fan(TUNED, scenario, signal, shown, responses.time, asked, low, median, high))
    return fans


def shown_signals(fans: list[Fan]) -> list[str]:
    """Return positions, the first rotor (the others look alike) and angles: a row of positions, a row of angles."""
    names = list(dict.fromkeys(fan.signal for fan in fans))
    rotors = [name for name in names if is_rotor(name)]
    axes = [name for name in names if not is_rotor(name)]
    return axes[:3] + rotors[:1] + axes[3:]


def draw_fan(ax: Axes, fan: Fan, role: str, label: str) -> None:
    """Draw band and median in the look of a role."""
    colour = COLOURS[role]
    ax.fill_between(fan.time, fan.low, fan.high, color=colour, alpha=0.2, linewidth=0)
    ax.plot(fan.time, fan.median, color=colour, linestyle=DASHES[role], label=label, zorder=4 if role == TUNED else 3)


def draw_references(ax: Axes, fans: list[Fan]) -> None:
    """Draw the reference where all fans have the same; what a law asks of itself (roll, pitch) differs: left out."""
    first = fans[0].reference
    if not np.isfinite(first).any() or any(not np.array_equal(first, fan.reference, equal_nan=True) for fan in fans):
        return
    look = {"linestyle": (0, (1, 1.5)), "linewidth": 0.9, "color": COLOURS["ink"], "zorder": 2}
    ax.plot(fans[0].time, first, label="reference", **look)


def _label(ax: Axes, fan: Fan) -> None:
    ax.set(xlabel="time [s]", ylabel=title(fan))
    ax.margins(x=0.0)
