"""Messages for pydantic's errors in a study file."""

from pathlib import Path

from pydantic import BaseModel, ValidationError

from plant.errors import InputError
from tuner.study.schema import ControllerTable, ObjectiveTable, ScenarioTable, SearchTable, StudyTable
from tuner.text.strict_table import NO_TEXTS, translate_error

# What to write where a required key is missing; [] stands for any entry of a list.
LINES = {
    "seed": "seed = 2025",
    "title": 'title = "Gains for hover in gusts"',
    "airframe": '[airframe] with name = "hummingbird"',
    "controller": '[controller] with attitude = "hybrid"',
    "controller.attitude": 'attitude = "hybrid"',
    "scenario": '[[scenario]] with name = "gusts"',
    "scenario[].name": 'name = "gusts"',
    "scenario[].air.gust.amplitude": "amplitude = 5.0  # m/s",
    "scenario[].air.gust.start": "start = 4.0  # s",
    "scenario[].air.gust.length": "length = 2.0  # s",
    "law.file": 'file = "my_law.py"',
    "metric.file": 'file = "my_metric.py"',
    "reference.file": 'file = "my_track.py"',
    "objective": '[[objective]] with metric = "itae.position"',
    "objective[].metric": 'metric = "itae.position"',
    "constraint[].metric": 'metric = "failure"',
    "constraint[].max": "max = 0.0",
    "guarantee[].theorem": 'theorem = "ultimate_error"',
    "guarantee[].axis": 'axis = "attitude"',
    "margin[].quantity": 'quantity = "phase_margin"',
    "contender[].name": 'name = "PID"',
    "published[].contender": 'contender = "PID"',
    "published[].metric": 'metric = "peak.roll"',
    "published[].scenario": 'scenario = "gusts"',
    "published[].value": "value = 0.083  # SI units",
    "claim[].better": 'better = "ADRC"',
    "claim[].than": 'than = ["PID"]',
    "claim[].in": 'in = ["peak.roll"]',
}
# Where a key belongs that stands at the top of the file, in front of the first table or behind the wrong one.
HOMES = {
    name: head
    for table, head in (
        (ScenarioTable, "[[scenario]]"),
        (ObjectiveTable, "[[objective]]"),
        (ControllerTable, "[controller]"),
        (SearchTable, "[search]"),
    )
    for name in table.model_fields
    if name not in StudyTable.model_fields
}


def translated(error: ValidationError, path: Path, root: type[BaseModel] = StudyTable) -> InputError:
    """Return the first problem of a pydantic error as an InputError; root: the validated table."""
    return translate_error(error, path, root, LINES, HOMES if root is StudyTable else NO_TEXTS)
