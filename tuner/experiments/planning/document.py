"""The plan of a tuning run as a document."""

from tuner.documents.plan import (
    AutomaticLimit,
    PilotPart,
    PlanDocument,
    PlannedFlights,
    PlannedObjective,
    PlannedSeconds,
    StreamFlights,
    StreamWidths,
)
from tuner.experiments.planning.cost import disk_of, flights_of, memory_of, seconds_of
from tuner.experiments.planning.pilot import FLIGHTS, Pilot
from tuner.experiments.planning.precision import HELD_OUT, STREAMS, Precision, precision_of
from tuner.experiments.tuning.conflicts import automatic_rows
from tuner.experiments.tuning.guards import warnings_before_run
from tuner.study.study import Study


def plan_document(study: Study, pilot: Pilot, compile_seconds: float | None, share: float) -> PlanDocument:
    """Return the whole plan; compile_seconds: None where the kernel was there; share: of the default's value, to be told."""
    precisions = [precision_of(study, pilot, i, share) for i in range(len(study.objectives))]
    return PlanDocument(
        title=study.title,
        study=study.path.name,
        digest=study.digest(),
        seed=study.seed,
        threads=pilot.threads,
        pilot=PilotPart(
            candidates=len(pilot.points),
            flights=pilot.flights,
            seconds=pilot.seconds,
            worth_flying_percent=100.0 * pilot.worthy_share,
        ),
        flights=planned_flights(study),
        seconds=planned_seconds(study, pilot, compile_seconds),
        memory_bytes=memory_of(study, pilot),
        disk_bytes_at_most=disk_of(study, pilot),
        difference_percent=100.0 * share,
        objectives=[planned_objective(entry) for entry in precisions],
        automatic_limits=[AutomaticLimit(**row) for row in automatic_rows(study.constraints)],
        warnings=warnings(study, pilot, precisions, share),
    )


def planned_flights(study: Study) -> PlannedFlights:
    """Return the flights of a run at most."""
    flights = flights_of(study)
    return PlannedFlights(
        search_at_most=flights.search,
        held_out_each=flights.held_out_each,
        finalists_at_most=flights.finalists,
        held_out_at_most=flights.held_out,
        total_at_most=flights.total,
    )


def planned_seconds(study: Study, pilot: Pilot, compile_seconds: float | None) -> PlannedSeconds:
    """Return the time of a run [s]."""
    seconds = seconds_of(study, pilot)
    return PlannedSeconds(
        compilation=compile_seconds,
        search=seconds.search,
        held_out_at_most=seconds.held_out,
        writing=seconds.writing,
        total_at_most=seconds.total,
    )


def planned_objective(found: Precision) -> PlannedObjective:
    """Return what to expect of one objective; a width that nothing can be said of is null."""
    percents = {stream: percent_of(found.widths[stream], found.default) for stream in STREAMS}
    return PlannedObjective(
        label=found.objective.label,
        unit=found.objective.metric.unit,
        default=found.default,
        flights=StreamFlights(**found.flights),
        width=StreamWidths(**found.widths),
        width_percent=StreamWidths(**percents),
        scenarios_needed=found.needed,
    )


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
