"""The seam between quadrotor, plant and FMU: whoever asks a system or a study asks a member, and never which kind it is."""

import ast

import pytest

from tests.sources import sources, walk

KINDS = {
    "FlownSystem",
    "System",
    "PlantSystem",
    "FmuSystem",
    "FmuFlyer",
    "PlantRecords",
    "PlantModel",
    "FmuModel",
    "SearchedStudy",
    "TuningStudy",
    "Study",
    "PlantStudy",
    "TrialStudy",
    "Contest",
    "Controller",
    "TunedLoops",
    "PlantMargins",
    "PlantSubject",
    "StudyPreview",
}


def asked(source):
    """Lines of a source that dispatch on a type, or ask for the kind of a system or a study."""
    for node in walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and any("singledispatch" in alias.name for alias in node.names):
            yield node.lineno
        if isinstance(node, ast.Attribute) and node.attr.startswith("singledispatch"):
            yield node.lineno
        if (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Name)
            and node.func.id in ("isinstance", "issubclass")
        ):
            names = {part.id for part in ast.walk(node.args[1]) if isinstance(part, ast.Name)}
            names |= {part.attr for part in ast.walk(node.args[1]) if isinstance(part, ast.Attribute)}
            if names & KINDS:
                yield node.lineno


def test_nobody_asks_a_system_or_a_study_which_kind_it_is():
    found = {name: list(asked(text)) for name, text in sources("tuner", pattern="isinstance|issubclass|singledispatch")}
    assert {file: lines for file, lines in found.items() if lines} == {}


@pytest.mark.parametrize(
    "source",
    [
        "from functools import cache, singledispatch",
        "import functools\n@functools.singledispatchmethod\ndef f(x): ...",
        "isinstance(study.system, objectives.PlantSystem)",
        "x = isinstance(a, int | Study)",
        "issubclass(kind, (str, FmuSystem))",
        "isinstance(system.plant, PlantModel)",
    ],
)
def test_each_way_to_ask_is_seen(source):
    assert list(asked(source))


def test_other_questions_are_let_through():
    assert not list(asked("isinstance(value, Path | StudyError)\nlogs = [Study for _ in systems]"))
