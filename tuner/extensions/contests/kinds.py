"""Kinds of study that are contests, their schemas, and the experiment."""

from pydantic import BaseModel

from tuner.experiments.registry import ExperimentKind
from tuner.extensions.contests.choices import CHOICES, choices_from_layers
from tuner.extensions.contests.reading import contest_from_layers
from tuner.extensions.contests.study import Contest
from tuner.extensions.contests.tables import ChoicesTable, ContestTable
from tuner.store.advice import CONTEST
from tuner.study.file_schema import Schema, study_schema, table_schema
from tuner.study.kinds import StudyKind
from tuner.study.plant_schema import PlantStudyTable
from tuner.study.schema import StudyTable

STUDY_WITH_CHOICES = StudyKind(CHOICES, "a study with choices", CHOICES, choices_from_layers)
STUDY = StudyKind(Contest.kind, "a contest", "contender", contest_from_layers)
HOME = "tuner.extensions.contests"
EXPERIMENT = ExperimentKind(
    CONTEST, f"{HOME}.run", "ContestRun", "contest.json", "a contest", progress=f"{HOME}.documents:contest_progress"
)
BASE: Schema = {
    "type": "string",
    "description": "Study whose tables lie under those of this file: a path, or a shipped name.",
}


def contest_schema(*added: type[BaseModel]) -> Schema:
    """Return the schema of a contest, of quadrotors or of plants."""
    parts = [study_schema(), table_schema(PlantStudyTable), *map(table_schema, added)]
    schema: Schema = {"type": "object", "properties": {"base": BASE}, "$defs": {}, "additionalProperties": False}
    for part in parts:
        schema["$defs"] |= part.get("$defs", {})
        for key, entry in part["properties"].items():
            before = schema["properties"].get(key, entry)
            # What quadrotors and plants have under one name is either.
            schema["properties"][key] = before if before == entry else {"anyOf": [before, entry]}
    for name in ("AirframeTable", "ControllerTable", "PlantTable"):
        schema["$defs"][name].pop("required", None)
    fields = [field for part in (StudyTable, *added) for field in part.model_fields.items()]
    needed = [key for key, field in fields if field.is_required() and key not in ("airframe", "controller")]
    # A base file may hold what this one leaves out.
    return {**schema, "description": added[-1].__doc__, "anyOf": [{"required": ["base"]}, {"required": needed}]}


def contest_study_schema() -> Schema:
    """Return the JSON Schema of the file of a contest."""
    return contest_schema(ContestTable)


def choices_study_schema() -> Schema:
    """Return the JSON Schema of the file of a study with choices."""
    return contest_schema(ChoicesTable)
