"""Spectra of commands: how much of what rotors or inputs are asked for is at which frequency."""

import numpy as np

from objectives.metrics.noise import CUTOFF
from tuner.documents.tables import PointSpectrum
from tuner.report.charts.chart import Axis, Line, Mark, Panel, Rule
from tuner.report.charts.look import RULE, Look

FREQUENCY = "frequency [Hz]"
DENSITY = "density [dB re 1/√Hz]"
# Density that stands for none.
MIN_DENSITY = 1e-12


def spectrum_mark(spectrum: PointSpectrum, look: Look, name: str) -> Mark:
    """Return the line of a spectrum, seen where its point and its scenario are."""
    level = 20.0 * np.log10(np.maximum(spectrum.density, MIN_DENSITY))
    show = {"point": spectrum.point, "scenario": spectrum.scenario}
    return Line(name=name, look=look, x=spectrum.frequency, y=level, tip="%{y:.1f} dB at %{x:.3~g} Hz", show=show)


def spectrum_panel(marks: list[Mark]) -> Panel:
    """Return the panel of spectra, with the frequency from which on the metric `noise` counts."""
    dotted = Rule(look=RULE, axis="x", value=CUTOFF)
    return Panel(
        "spectrum",
        "Spectrum of the commands",
        Axis(FREQUENCY, log=True, step=1),
        Axis(DENSITY),
        [dotted, *marks],
        aid="Of default and recommended gains, over all rotors or inputs. Dotted: from here on the metric noise counts.",
    )
