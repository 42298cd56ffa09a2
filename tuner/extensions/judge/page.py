"""The page of a second opinion, judge.md: subjects, flights, margins, rules, changes, and the way back."""

from tuner.documents.assessment import AssessmentDocument
from tuner.documents.parts import ShareCount
from tuner.report.opinion_section import NONE, assessment_tables
from tuner.text.numbers import significant


def assessment_page(document: AssessmentDocument) -> str:
    """Return the page as Markdown."""
    tables = [f"## {table.title}\n\n{table.markdown}" for table in assessment_tables(document)]
    unmodeled = "\n".join(f"- {line}" for line in unmodeled_lines(document))
    parts = [
        f"# Second opinion: {document.verdict}",
        *([f"Not in the model, or assumed:\n\n{unmodeled}"] if unmodeled else []),
        f"**{document.sentence}**",
        *subject_lines(document),
        *tables,
        *rollback_lines(document),
    ]
    # Texts of files are no markup: neither HTML nor links.
    return "\n\n".join(parts).replace("<", "&lt;").replace("](", "] (") + "\n"


def unmodeled_lines(document: AssessmentDocument) -> list[str]:
    """Return vehicle, changed parameters and notes in sentences."""
    vehicle = document.airframe
    unknown = f"No airframe was named: judged on the {vehicle.title} ({vehicle.ranges}). Name one with --airframe."
    changed = [f"{row.name} {row.before or NONE} to {row.after or NONE}" for row in document.unmodeled_changes]
    beyond = f"Changed, and in no loop of the model: {', '.join(changed)}."
    is_known = vehicle.is_known or document.lost_after is None
    return [*([] if is_known else [unknown]), *([beyond] if changed else []), *document.unmodeled]


def subject_lines(document: AssessmentDocument) -> list[str]:
    """Return files, vehicle and flights in sentences."""
    vehicle, before = document.airframe, document.before
    than = "" if before is None else f", before: {before.file}"
    guessed = [] if document.guessed is None else [document.guessed]
    if document.gyro_noise is None:
        return [*guessed, f"Not judged, and not flown: {document.after.file}{than}."]
    noise = f"{significant(document.gyro_noise.value, 2)} {document.gyro_noise.unit}"
    flights = f"{document.flights} flights" + ("" if before is None else " of each file, paired")
    return [
        *guessed,
        f"Judged: {document.after.file}{than}; vehicle: {vehicle.name}, {vehicle.title} ({vehicle.ranges}).",
        f"{flights}: {document.scenario}; gyro noise {noise}; lost {lost_text(document)}.",
        *(
            f"{row.flights} flights: {row.name}; lost {lost_words(row.lost_after, row.lost_before)}."
            for row in document.further
        ),
    ]


def lost_text(document: AssessmentDocument) -> str:
    """Return the lost flights in words."""
    return NONE if document.lost_after is None else lost_words(document.lost_after, document.lost_before)


def lost_words(after: ShareCount, before: ShareCount | None) -> str:
    """Return lost flights in words, with those before."""
    return after.words + ("" if before is None else f", before {before.words}")


def rollback_lines(document: AssessmentDocument) -> list[str]:
    """Return the way back in sentences."""
    lines = [] if document.rollback is None else [f"To go back, load {document.rollback}."]
    if document.rollback is not None and document.not_restored:
        lines.append(f"It does not hold, so set by hand: {', '.join(document.not_restored)}.")
    return lines
