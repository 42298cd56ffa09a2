"""The plan of a run as data, for JSON and for the terminal."""

from typing import Any

from tuner.experiments.planning.cost import disk_of, flights_of, memory_of, seconds_of
from tuner.experiments.planning.pilot import FLIGHTS, Pilot
from tuner.experiments.planning.precision import HELD_OUT, STREAMS, Precision, precision_of
from tuner.experiments.tuning.conflicts import automatic_rows
from tuner.experiments.tuning.guards import warnings_before_run
from tuner.study.study import Study

Row = dict[str, Any]


def plan_document(study: Study, pilot: Pilot, compile_seconds: float | None, share: float) -> Row:
    """Return the whole plan; compile_seconds: None where the kernel was there; share: of the default's value, to be told."""
    flights, seconds = flights_of(study), seconds_of(study, pilot)
    precisions = [precision_of(study, pilot, i, share) for i in range(len(study.objectives))]
    return {
        "title": study.title,
        "study": study.path.name,
        "digest": study.digest(),
        "seed": study.seed,
        "threads": pilot.threads,
        "pilot": {
            "candidates": len(pilot.points), "flights": pilot.flights, "seconds": pilot.seconds,
            "worth_flying_percent": 100.0 * pilot.worthy_share,
        },
        "flights": {
            "search_at_most": flights.search, "held_out_each": flights.held_out_each, "finalists_at_most": flights.finalists,
            "held_out_at_most": flights.held_out, "total_at_most": flights.total,
        },
        "seconds": {
            "compilation": compile_seconds, "search": seconds.search, "held_out_at_most": seconds.held_out,
            "writing": seconds.writing, "total_at_most": seconds.total,
        },
        "memory_bytes": memory_of(study, pilot),
        "disk_bytes_at_most": disk_of(study, pilot),
        "difference_percent": 100.0 * share,
        "objectives": [objective_row(entry) for entry in precisions],
        "automatic_limits": automatic_rows(study.constraints),
        "warnings": warnings(study, pilot, precisions, share),
    }  # fmt: skip


def objective_row(found: Precision) -> Row:
    """Return what to expect of one objective; a width that nothing can be said of is null."""
    return {
        "label": found.objective.label,
        "unit": found.objective.metric.unit,
        "default": found.default,
        "flights": found.flights,
        "width": found.widths,
        "width_percent": {stream: percent_of(found.widths[stream], found.default) for stream in STREAMS},
        "scenarios_needed": found.needed,
    }


def percent_of(width: float | None, value: float) -> float | None:
    """Return a width in percent of a value, or None."""
    return None if width is None or value == 0.0 else 100.0 * width / abs(value)


def warnings(study: Study, pilot: Pilot, precisions: list[Precision], share: float) -> list[str]:
    """Return what should be changed, or known, before the run."""
    said = warnings_before_run(study)
    lost = sum(int(entry.failed[0].sum(axis=0)) for entry in pilot.scenarios)
    if lost:
        said.append(
            f"The default lost {lost} of {FLIGHTS * len(pilot.scenarios)} pilot flights; its values and widths are those of "
            "failures. Start from other gains, or make the scenarios milder."
        )
    if pilot.worthy_share == 0.0:
        said.append(
            "None of the points looked at keeps every hard requirement; narrow the ranges of the gains towards a design "
            "(`tuner design`), or relax a requirement."
        )
    for entry in precisions:
        have = entry.flights[HELD_OUT]
        if entry.needed is not None and entry.needed > have:
            said.append(
                f"{entry.objective.label}: {have} held-out scenarios do not surely tell a difference of {100.0 * share:g} %; "
                f"{entry.needed} would."
            )
    return said
