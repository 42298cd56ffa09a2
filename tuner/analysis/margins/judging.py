"""Margins of gains, with limits of a study or the usual ones."""

import numpy as np

from objectives.margins.trim import Trim
from plant.errors import InputError
from tuner.analysis.margins.document import (
    default_requirements,
    margins_document,
    plant_margins_document,
    plant_requirements,
    requirements_in,
    rows_without_loop,
    study_requirements,
)
from tuner.analysis.margins.readings import Loops, plant_subject, subject_of
from tuner.documents.margins import CertificateRow, MarginsDocument
from tuner.extension import added, load
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
        document = document.model_copy(update={"certificates": _proved("quadrotor", controller)})
    return subject, document, limits is not None


def judge_plant(controller: PlantController, by_study: bool, certified: bool) -> Judged:
    """Return the margins at rest; by_study: by the limits of the controller's study."""
    subject = plant_subject(controller.study.system, np.array(controller.gains))
    limits = plant_requirements(controller.study, subject.row) if by_study else None
    rows = default_requirements(subject) if limits is None else limits
    document = plant_margins_document(subject, [*rows, *rows_without_loop(controller.study, subject.row)])
    if certified:
        document = document.model_copy(update={"certificates": _proved("plant", subject)})
    return subject, document, limits is not None


def _proved(kind: str, subject: Controller | Loops) -> list[CertificateRow]:
    """Return the certificates of a kind of controller, InputError without their extension."""
    references = added("certificates")
    if kind not in references:
        message = f"no installed extension proves anything of a {kind}; install one, such as certificates of gainproof"
        raise InputError(message, key="--certificates")
    return load(references[kind])(subject)
