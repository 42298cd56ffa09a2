"""Margins of gains, with limits of a study or the usual ones."""

import numpy as np

from objectives.margins.trim import Trim
from tuner.analysis.margins.document import (
    certificate_rows,
    default_requirements,
    margins_document,
    plant_margins_document,
    plant_requirements,
    requirements_in,
    study_requirements,
)
from tuner.analysis.margins.readings import Loops, plant_subject, subject_of
from tuner.documents.margins import MarginsDocument
from tuner.gains import Controller
from tuner.study.plant_controller import PlantController
from tuner.study.study import Study

Judged = tuple[Loops, MarginsDocument, bool]
"""Loops, the document of their margins, and whether its limits are those of the study."""


def judge_quadrotor(controller: Controller, trim: Trim, study: Study | None, certified: bool) -> Judged:
    """Return the margins in a trim, or in a study's states."""
    subject, limits = subject_of(controller, trim), None
    if study is not None:
        limits = study_requirements(study, controller, None if trim == Trim() else trim)
    document = margins_document(subject, requirements_in(subject) if limits is None else limits)
    if certified:
        document = document.model_copy(update={"certificates": certificate_rows(controller)})
    return subject, document, limits is not None


def judge_plant(controller: PlantController, by_study: bool, certified: bool) -> Judged:
    """Return the margins at rest; by_study: by the limits of the controller's study."""
    subject = plant_subject(controller.study.system, np.array(controller.gains))
    limits = plant_requirements(controller.study, subject.row) if by_study else None
    document = plant_margins_document(subject, default_requirements(subject) if limits is None else limits)
    if certified:
        # What proves them takes a second to import.
        from tuner.analysis.margins.plant_certificates import plant_certificate_rows

        document = document.model_copy(update={"certificates": plant_certificate_rows(subject)})
    return subject, document, limits is not None
