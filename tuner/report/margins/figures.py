"""All figures of `tuner margins --out`: bode, nyquist, nichols, responses and mismatch, each as PNG and PDF."""

from pathlib import Path

from tuner.analysis.margins.curves import curves_of, groups
from tuner.analysis.margins.linear import Linear
from tuner.analysis.margins.mismatch import Extent, extents, mismatch_map
from tuner.analysis.margins.readings import Subject
from tuner.analysis.margins.time_response import time_responses
from tuner.report.charts.paper import save, style
from tuner.report.margins.loop_figures import bode_figure, nichols_figure, nyquist_figure
from tuner.report.margins.mismatch_figure import mismatch_figure
from tuner.report.margins.response_figure import response_figure

MAPS = (("mass", "inertia"), ("thrust", "lag"))


def write_margin_figures(subject: Subject, folder: Path) -> list[Extent]:
    """Write the figures into an existing folder; return how far single factors of the vehicle may go."""
    panels = {group: curves_of(subject, group[0]) for group in groups(subject)}
    found = time_responses(subject.controller, subject.trim, tuple(group[0] for group in panels))
    responses = dict(zip(panels, found, strict=True))
    linear = Linear(subject.controller, subject.trim)
    ends = extents(linear)
    maps = [mismatch_map(linear, across, up, ends) for across, up in MAPS]
    labels = tuple(case.label for case in linear.cases)
    with style():
        save(bode_figure(subject, panels), folder, "bode")
        save(nyquist_figure(subject, panels), folder, "nyquist")
        save(nichols_figure(subject, panels), folder, "nichols")
        save(response_figure(responses, labels), folder, "responses")
        save(mismatch_figure(maps, ends), folder, "mismatch")
    return ends
