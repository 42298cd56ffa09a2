"""Tools of agents: every one is a command, its arguments are that command's, and nothing that an agent gives becomes an option."""

import jsonschema
import pytest
from typer.testing import CliRunner

from plant.errors import InputError
from tests.tuner.exchange.hostile_texts import HOSTILE
from tuner.cli.app import TextKind
from tuner.cli.main import app
from tuner.extensions.agents.tools import TOOLS, Effect, command_line, commands, parameters_of, schema_of, tools

WRITTEN = [text for text in HOSTILE if "\ud800" not in text]
FEW = [*(text for text in WRITTEN if text.startswith(("-", ".", "/", "~"))), *WRITTEN[::9]]
"""Texts for all but the first parameter of a kind that a command has: they differ by the name of their option alone."""
EVERY = pytest.mark.parametrize("name", commands())


@pytest.fixture
def root(tmp_path):
    folder = tmp_path / "root"
    folder.mkdir()
    (tmp_path / "secret.toml").write_text("")
    (folder / "link.toml").symlink_to(tmp_path / "secret.toml")
    return folder


def test_the_commands_of_the_task_are_there():
    assert {"new", "design", "rejudge", "tail", "identify", "judge", "autotune", "run", "export"} <= set(commands())
    assert list(commands()) == list(TOOLS)


@EVERY
def test_each_argument_is_one_of_the_command(name):
    text = CliRunner().invoke(app, [name, "--help"], env={"COLUMNS": "300"}).stdout
    for parameter in parameters_of(name).values():
        assert parameter.flag in text
        assert parameter.schema["description"][:30] in " ".join(text.split())
    assert not {"json", "threads", "dask", "backend"} & set(parameters_of(name))


@EVERY
def test_schemas_are_schemas_and_descriptions_have_an_example(name):
    (tool,) = [each for each in tools() if each.name == name]
    jsonschema.Draft202012Validator.check_schema(tool.input_schema)
    assert tool.input_schema == schema_of(name)
    assert tool.description is not None and tool.annotations is not None
    assert f"Example: tuner {name}" in " ".join(tool.description.split())
    assert tool.annotations.read_only_hint is tool.annotations.idempotent_hint is (TOOLS[name].effect is Effect.READ)
    assert tool.annotations.destructive_hint is (TOOLS[name].effect is Effect.CHANGE)


def test_values_become_options_and_arguments(root):
    given = {"study": "quickstart", "out": "first", "set": ["search.generations=2", "seed=7"]}
    assert command_line("run", given, root) == [
        "run", "--out=first", "--set=search.generations=2", "--set=seed=7", "--json", "--", "quickstart",
    ]  # fmt: skip
    line = command_line("margins", {"speed": -2.5, "attitude_only": True, "certificates": False}, root)
    assert line == ["margins", "--speed=-2.5", "--attitude-only", "--json", "--"]


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("reboot", {}, "there is no tool 'reboot'"),
        ("run", {}, "study: is missing"),
        ("run", {"study": "quickstart", "threads": 4}, "threads: there is no such argument"),
        ("run", {"study": "quickstart", "set": "seed=1"}, "set: must be a list"),
        ("run", {"study": ["quickstart"]}, "study: must be one value"),
        ("run", {"study": {"a": 1}}, "study: given a dict"),
        ("run", {"study": "a\0b"}, "study: must be a text"),
        ("run", {"study": "a" * 5000}, "study: must be a text"),
        ("run", {"study": "--code"}, "study: given '--code'; write ./--code"),
        ("run", {"study": "/etc/passwd"}, "study: given '/etc/passwd', which lies outside"),
        ("run", {"study": "../secret.toml"}, "study: given '../secret.toml', which lies outside"),
        ("run", {"study": "link.toml"}, "study: given 'link.toml', which lies outside"),
        ("run", {"study": "quickstart", "out": "../away"}, "out: given '../away', which lies outside"),
        ("run", {"study": "quickstart", "set": ["vehicle.airframe=../secret.toml"]}, "which lies outside"),
        ("run", {"study": "quickstart", "set": ['vehicle.airframe="\\u002e./secret.toml"']}, "which lies outside"),
        (
            "run",
            {"study": "quickstart", "set": ['search.starts=["mine", {a = "../secret.toml"}]']},
            "which lies outside",
        ),
        (
            "run",
            {"study": "quickstart", "set": ["k=" + "a" * 4000] * 30},
            "the arguments have more than 100,000 letters",
        ),
        ("run", {"study": "a\ud800"}, "study: must be a text"),
        ("run", {"study": True}, "study: given True; it must be string"),
        ("margins", {"attitude_only": "yes"}, "attitude_only: given 'yes'; it must be boolean"),
        ("list", {"containing": "pid"}, "what: is missing; containing needs it"),
        ("run", {"study": "link"}, "study: given 'link.toml', which lies outside"),
        ("identify", {"logs": ["link.toml@70:76"]}, "logs: given 'link.toml', which lies outside"),
        ("identify", {"logs": ["../a@1:2", "b"]}, "logs: given '../a@1:2', which lies outside"),
        ("autotune", {"logs": ["log"], "vehicle": "a", "airframe": "x", "binary": "../b=c"}, "binary: given '../b=c'"),
        ("margins", {"airframe": "~/mine.toml"}, "airframe: given '~/mine.toml', which lies outside"),
    ],
)
def test_what_no_tool_takes_is_refused(name, given, message, root):
    with pytest.raises(InputError, match=message.replace(".", r"\.").replace("'", ".")):
        command_line(name, given, root)


@EVERY
def test_hostile_texts_stay_one_argument_or_are_refused(name, root):
    known = set()
    for label, parameter in parameters_of(name).items():
        kind = parameter.kind, parameter.type, parameter.is_list, bool(parameter.flag)
        texts = FEW if kind in known else WRITTEN
        known.add(kind)
        others = {
            key: ["a"] if each.is_list else "a"
            for key, each in parameters_of(name).items()
            if each.is_required or not each.flag
        }
        # A change has a key, in front of the text.
        key = "k=" if parameter.kind is TextKind.CHANGE else ""

        def line_with(text, others=others, label=label, parameter=parameter):
            return command_line(name, others | {label: [text] if parameter.is_list else text}, root)

        if parameter.type is bool:
            with pytest.raises(InputError, match="it must be boolean"):
                line_with("a")
            continue
        plain = line_with(f"{key}a")
        for text in [f"{key}{each}" for each in texts]:
            try:
                line = line_with(text)
            except InputError:
                continue
            changed = [(now, before) for now, before in zip(line, plain, strict=True) if now != before]
            flag = f"{parameter.flag}=" if parameter.flag else ""
            assert set(changed) <= {(f"{flag}{text}", f"{flag}{key}a")}
