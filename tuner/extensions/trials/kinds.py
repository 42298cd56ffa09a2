"""The kind of study whose trials another program makes, and its experiment."""

from typing import Any

from tuner.experiments.registry import ExperimentKind
from tuner.extensions.trials.study import TrialStudy, TrialStudyTable, trials_from_layers
from tuner.study.file_schema import table_schema
from tuner.study.kinds import StudyKind

STUDY = StudyKind(TrialStudy.kind, "a study whose trials another program makes", "trials", trials_from_layers)
EXPERIMENT = ExperimentKind(
    TrialStudy.kind, "tuner.extensions.trials.run", "TrialRun", "summary.json", "a run of trials"
)


def study_schema() -> dict[str, Any]:
    """Return the JSON Schema of the study file."""
    return table_schema(TrialStudyTable)
