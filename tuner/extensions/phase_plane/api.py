"""Phase planes from Python."""

from pathlib import Path
from typing import TYPE_CHECKING

from tuner.api.flying import Flights
from tuner.extensions.phase_plane.figure import phase_sheet
from tuner.extensions.phase_plane.trajectories import trajectories
from tuner.report.charts.paper import drawn, style
from tuner.report.figures import write_figure

if TYPE_CHECKING:
    from tuner.report.charts.paper import Figure


def phase_plane(flights: Flights, file: str | Path | None = None) -> "Figure":
    """Draw the error of each loop against its rate.

    Args:
        flights: Flights that `tuner.fly` made, under any law.
        file: File to write; its ending, .png, .pdf or .svg, says the format.

    Returns:
        The figure, made without pyplot.

    Raises:
        InputError: The ending is none of these, or the file cannot be written.

    Examples:
        >>> tuner.phase_plane(tuner.fly(gains, flights=4)).savefig("phase.png")

    """
    with style():
        figure = drawn(phase_sheet(trajectories(flights.recorded), flights.scenario))
        if file is not None:
            write_figure(figure, Path(file))
    return figure
