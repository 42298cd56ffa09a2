"""One figure of the responses of one controller: what `tuner fly --plot` writes."""

from pathlib import Path

import numpy as np

from plant.errors import InputError
from tuner.report.figures import blank, draw_fan
from tuner.report.results import TUNED, Fan
from tuner.report.units import bracketed, in_degrees
from tuner.responses import SIGNALS, UNITS, Responses

ENDINGS = (".png", ".pdf", ".svg")
SHOWN = 7


def write_responses(responses: Responses, scenario: str, file: Path) -> None:
    """Write the Monte Carlo fans of the six axes and of one rotor; the ending of the file says the format."""
    if file.suffix.lower() not in ENDINGS:
        raise InputError(f"given '{file}'; allowed endings: {', '.join(ENDINGS)}", key="--plot")
    low, median, high = responses.fans()
    reference = responses.reference.mean(axis=0)
    figure, axes = blank(2, 4, 2.0)
    for i, ax in enumerate(axes):
        ax.set_visible(i < SHOWN)
        if i < SHOWN:
            unit, factor = in_degrees(UNITS[i])
            series = [np.asarray(line[:, i]) * factor for line in (reference, low, median, high)]
            draw_fan(ax, Fan("", scenario, SIGNALS[i], unit, responses.time, *series), TUNED)
            ax.set_ylabel(bracketed(SIGNALS[i], unit), fontsize=8)
    axes[SHOWN - 1].set_xlabel("time [s]", fontsize=8)
    figure.suptitle(f"{scenario}: median and 5-95 % of {len(responses.actual)} flights", fontsize=9)
    try:
        figure.savefig(file, dpi=160)
    except OSError as error:
        raise InputError(f"{file} cannot be written ({error.strerror})", key="--plot") from error
