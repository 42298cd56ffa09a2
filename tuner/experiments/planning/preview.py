"""A study of any kind before anything flies: its content in numbers, and what is known to stand in its way."""

from collections.abc import Callable
from typing import Any

from tuner.experiments.planning.study_preview import PreviewPart, StudyPreview, plant_preview, study_preview
from tuner.extension import added, load
from tuner.study.kinds import AnyStudy
from tuner.study.plant_study import PlantStudy
from tuner.study.study import Study

Preview = StudyPreview | PreviewPart


def preview(study: AnyStudy) -> Preview:
    """Return a study's preview, computed without flying."""
    made = PREVIEWS[study.kind] if study.kind in PREVIEWS else load(added("previews")[study.kind])
    return made(study)


PREVIEWS: dict[str, Callable[[Any], Preview]] = {
    Study.kind: study_preview,
    PlantStudy.kind: plant_preview,
}
"""Previews by the kind of study of the core; those of extensions are in their records."""
