"""JSON documents that the tool writes and study files that it reads, by name; `tuner schema NAME` prints the schema of each."""

import json

from plant.errors import UnknownNameError
from tuner.documents.assessment import AssessmentDocument
from tuner.documents.comparison_document import ComparisonDocument
from tuner.documents.export import ExportDocument
from tuner.documents.judgement import JudgementDocument
from tuner.documents.margins import MarginsDocument
from tuner.documents.plan import PlanDocument
from tuner.documents.resolved import Resolved
from tuner.documents.summary import Summary
from tuner.documents.variables import VariablesDocument
from tuner.extension import objects, refuse_lacking
from tuner.gains.schema import schema_text
from tuner.store.document import Document
from tuner.store.environment import Environment
from tuner.store.inputs import RunRecord
from tuner.store.manifest import Manifest
from tuner.store.start import Start
from tuner.study.file_schema import DIALECT, study_schemas

GAINS = "gains"
DOCUMENTS: dict[str, type[Document]] = {
    "summary": Summary,
    "comparison": ComparisonDocument,
    "margins": MarginsDocument,
    "plan": PlanDocument,
    "judgement": JudgementDocument,
    "assessment": AssessmentDocument,
    "export": ExportDocument,
    "variables": VariablesDocument,
    "resolved": Resolved,
    "environment": Environment,
    "run": RunRecord,
    "start": Start,
    "manifest": Manifest,
    **objects("documents"),
}


def schema_of(name: str) -> str:
    """Return a JSON Schema as the text of a file; UnknownNameError where there is none."""
    if name == GAINS:
        return schema_text()
    if name in study_schemas():
        schema = study_schemas()[name]()
    elif name in DOCUMENTS:
        schema = DOCUMENTS[name].model_json_schema(by_alias=True)
    else:
        refuse_lacking("schemas", name)
        refuse_lacking("documents", name)
        raise UnknownNameError("schema", name, schema_names())
    return json.dumps({"$schema": DIALECT, **schema}, indent=1) + "\n"


def schema_names() -> list[str]:
    """Return the names of all schemas."""
    return [GAINS, *study_schemas(), *DOCUMENTS]
