"""Every JSON document that the tool writes, by name; `tuner schema NAME` prints its JSON Schema."""

import json

from plant.errors import UnknownNameError
from tuner.documents.approach import ApproachDocument
from tuner.documents.confirmation import ConfirmationDocument
from tuner.documents.contest_document import ComparisonDocument, ContestDocument
from tuner.documents.estimate import EstimateDocument
from tuner.documents.export import ExportDocument
from tuner.documents.flight_plan import FlightPlanDocument
from tuner.documents.identification import IdentificationDocument, LogCheckDocument
from tuner.documents.inference_document import InferenceDocument
from tuner.documents.judgement import JudgementDocument
from tuner.documents.log_comparison import LogComparisonDocument
from tuner.documents.margins import MarginsDocument
from tuner.documents.plan import ContestPlanDocument, PlanDocument
from tuner.documents.resolved import Resolved
from tuner.documents.sensitivity import SensitivityDocument
from tuner.documents.summary import Summary
from tuner.documents.variables import VariablesDocument
from tuner.gains.schema import schema_text
from tuner.store.document import Document
from tuner.store.environment import Environment
from tuner.store.inputs import RunRecord
from tuner.store.manifest import Manifest
from tuner.store.start import Start

GAINS = "gains"
DOCUMENTS: dict[str, type[Document]] = {
    "summary": Summary,
    "contest": ContestDocument,
    "comparison": ComparisonDocument,
    "inference": InferenceDocument,
    "sensitivity": SensitivityDocument,
    "margins": MarginsDocument,
    "plan": PlanDocument,
    "contest-plan": ContestPlanDocument,
    "airframe-estimate": EstimateDocument,
    "identification": IdentificationDocument,
    "flight-plan": FlightPlanDocument,
    "log-check": LogCheckDocument,
    "log-comparison": LogComparisonDocument,
    "judgement": JudgementDocument,
    "export": ExportDocument,
    "confirmation": ConfirmationDocument,
    "approach": ApproachDocument,
    "variables": VariablesDocument,
    "resolved": Resolved,
    "environment": Environment,
    "run": RunRecord,
    "start": Start,
    "manifest": Manifest,
}


def schema_of(name: str) -> str:
    """Return the JSON Schema of a document, or of gains.json, as the text of a file; UnknownNameError where there is none."""
    if name == GAINS:
        return schema_text()
    if name not in DOCUMENTS:
        raise UnknownNameError("schema", name, [GAINS, *DOCUMENTS])
    schema = DOCUMENTS[name].model_json_schema(by_alias=True)
    return json.dumps({"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}, indent=1) + "\n"
