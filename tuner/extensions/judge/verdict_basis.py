"""Basis of a verdict: rate gains of the files, a known version, configuration as it is flown; without it nothing is judged."""

from collections.abc import Sequence

from plant.errors import shortened
from tuner.documents.assessment import NOT_JUDGED, AssessmentDocument, ParameterChange
from tuner.extensions.autopilots.sources import GAINS, sources
from tuner.extensions.judge.configuration import (
    configuration_reasons,
    listed,
    unusual_configuration,
)
from tuner.extensions.judge.vehicle_files import GainsFile, GivenFiles, Subjects, file_part
from tuner.gains import Controller

NOT_THERE = "-"
AIRFRAME_ADVICE = "give the airframe of this vehicle with --airframe"


def missing_basis(subjects: Subjects) -> list[str]:
    """Return the reasons for which files cannot be judged."""
    if subjects.source == GAINS:
        return []
    after, before = subjects.after, subjects.before
    gain = sources()[subjects.source].rate_gain
    lacking = [
        f"no gain of a rate loop is in {file.path.name}, and the firmware's defaults are no vehicle's: give all of its parameters"
        for file in (after, before)
        if file is not None and not any(map(gain.fullmatch, file.values))
    ]
    if lacking:
        return lacking
    present = None if before is None else _configuration(before)
    reasons = configuration_reasons(subjects.source, present, _configuration(after)) or _unmodeled_alone(subjects)
    return [*other_vehicle_reasons(subjects), *reasons]


def other_vehicle_reasons(subjects: Subjects) -> list[str]:
    """Return a reason for numbers of another vehicle than the airframe."""
    refusing = [row for row in subjects.contradictions if row.refuses]
    texts = dict.fromkeys(row.sentence(_subject(subjects)) for row in refusing)
    return [f"{listed(list(texts))}: {AIRFRAME_ADVICE}"] if refusing else []


def configuration_notes(subjects: Subjects) -> list[str]:
    """Return sentences on unusual settings, and on numbers that the airframe contradicts."""
    unusual = unusual_configuration(subjects.source, _configuration(subjects.after))
    texts = dict.fromkeys(row.sentence(_subject(subjects)) for row in subjects.contradictions if not row.refuses)
    contradicted = [f"{text}: {AIRFRAME_ADVICE}." for text in texts]
    if not unusual:
        return contradicted
    settings = listed([f"{name} = {value}" for name, value in unusual.items()])
    return [f"Not at the firmware's default, and flown as if it fitted the vehicle: {settings}.", *contradicted]


def unjudged_document(
    given: GivenFiles, subjects: Subjects | None, reasons: Sequence[str], seed: int, seconds: dict[str, float]
) -> AssessmentDocument:
    """Return the content of assessment.json where a verdict has no basis.

    Args:
        given: Files and vehicle.
        subjects: Gains of the files, None where they were not read.
        reasons: Reasons for which nothing is judged.
        seed: Root seed.
        seconds: Time of each stage.
    """
    after, before = (None if file is None else file_part(file, given.source) for file in (given.after, given.before))
    assert after is not None
    changes: list[ParameterChange] = []
    not_restored: list[str] = []
    if subjects is not None:
        after, before = subjects.after.part, None if subjects.before is None else subjects.before.part
        changes, not_restored = subjects.unmodeled_changes, subjects.not_restored
    return AssessmentDocument(
        format="gainproof-assessment",
        version="0.1",
        verdict=NOT_JUDGED,
        comparison=None,
        sentence=f"Not judged: {'; '.join(reasons)}.",
        reasons=list(reasons),
        unmodeled=[] if subjects is None else list(subjects.after.notes),
        unmodeled_changes=changes,
        guessed=given.guessed,
        after=after,
        before=before,
        airframe=given.assumed,
        changes=[],
        loops=[],
        rules=[],
        scenario="",
        seed=seed,
        flights=0,
        gyro_noise=None,
        metrics=[],
        lost_after=None,
        lost_before=None,
        rollback=None,
        not_restored=not_restored,
        seconds=seconds,
    )


def _flown(controller: Controller) -> tuple[object, ...]:
    """Return the parts of a controller that files of one firmware change."""
    return controller.gains, controller.options, controller.control_period


def _subject(subjects: Subjects) -> str:
    """Return the airframe as the subject of a sentence."""
    airframe = subjects.airframe
    return f"the airframe {airframe.name}" if airframe.is_known else f"the {airframe.title.partition(',')[0]}"


def _configuration(file: GainsFile) -> dict[str, str | float]:
    return {**file.values, **file.wiring}


def _unmodeled_alone(subjects: Subjects) -> list[str]:
    """Return a reason where parameters differ, and none that the model flies."""
    if subjects.before is None or not subjects.changed_parameters:
        return []
    if _flown(subjects.after.gains.controller) != _flown(subjects.before.gains.controller):
        return []
    texts = listed(
        [
            f"{shortened(row.name)} {row.before or NOT_THERE} to {row.after or NOT_THERE}"
            for row in subjects.changed_parameters
        ]
    )
    return [f"nothing that the model flies differs, only: {texts}"]
