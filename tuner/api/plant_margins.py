"""Margins of gains of a plant of the user's own, by its study: that of its results folder, or another one."""

from pathlib import Path

from plant.errors import InputError
from tuner.analysis.margins.document import default_requirements, plant_margins_document, plant_requirements
from tuner.analysis.margins.readings import PlantSubject, plant_subject
from tuner.api.plants import study_of
from tuner.api.studies import StudyLike, gains_study
from tuner.documents.margins import MarginsDocument
from tuner.study.plant_study import PlantStudy
from tuner.study.tuned_loops import read_plant_row


def check_at_rest(*settings: float | bool) -> None:
    """Refuse settings of a quadrotor's steady flight, which must be those of hover: a plant is looked at where it rests."""
    if any(settings):
        raise InputError(
            "yaw, speed, wind and attitude mode are those of quadrotors; leave them out: a plant is linearised where it rests"
        )


def plant_margins_of(gains: Path, study: StudyLike | None) -> tuple[PlantSubject, MarginsDocument, bool]:
    """Return the loops under a plant's gains.json, their document, and whether its limits are those of the study given.

    Without a study, that of the results folder says what the loops are, and limits are the usual ones.
    """
    asked = study_of(gains) if study is None else plant_study(study, "tuner margins --study")
    subject = plant_subject(asked.system, read_plant_row(gains, asked.system))
    limits = None if study is None else plant_requirements(asked, subject.row)
    document = plant_margins_document(subject, default_requirements(subject) if limits is None else limits)
    return subject, document, limits is not None


def plant_study(study: StudyLike, asking: str) -> PlantStudy:
    """Return a study of a plant; InputError where it is of another kind. asking: who takes no other."""
    found = gains_study(study, asking)
    if not isinstance(found, PlantStudy):
        raise InputError(
            "this is a study of a quadrotor, and the gains are those of a plant; give the study of the plant",
            file=found.path,
            key="plant",
        )
    return found
