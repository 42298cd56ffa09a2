"""Tools of an agent: each is a command of `tuner`, with the command's own arguments, help and answer."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from inspect import Signature, getdoc, signature
from pathlib import Path
from types import NoneType
from typing import Any, NamedTuple, get_args, get_origin

from mcp.types import Tool, ToolAnnotations
from typer.models import OptionInfo

from plant.errors import InputError
from tuner.cli.app import app

READING = ("check", "plan", "show", "margins", "list")
"""Commands that leave files as they are."""
COMMANDS = (*READING, "judge", "import", "autotune", "run", "resume", "compare", "fly", "export")
"""Commands that agents may call, as far as this version has them. None of them speaks to a vehicle."""
EXCLUDED = frozenset({"json", "threads", "dask", "backend", "plot"})
"""Options that concern the terminal or the machine."""
TYPES = {bool: "boolean", int: "integer", float: "number"}
"""Types of the command line -> types of JSON; all others are texts."""
MOST_LETTERS = 4096
"""Letters of a text that an argument may have."""


class Parameter(NamedTuple):
    """A parameter of a command.

    Attributes:
        type: of a value.
        is_list: whether it takes several values.
        is_required: whether it has no default.
        info: its description for the command line.
        flag: of an option, empty for an argument.
    """

    type: type
    is_list: bool
    is_required: bool
    info: Any
    flag: str

    @property
    def schema(self) -> dict[str, Any]:
        """JSON schema of its value."""
        schema: dict[str, Any] = {"type": TYPES.get(self.type, "string")}
        for key, bound in (("minimum", self.info.min), ("maximum", self.info.max)):
            if bound is not None:
                schema[key] = bound
        if self.is_list:
            schema = {"type": "array", "items": schema}
        return schema | ({"description": self.info.help} if self.info.help else {})


@cache
def commands() -> dict[str, Callable[..., object]]:
    """Return the functions of the commands that are tools, by their names."""
    functions = {
        info.name or info.callback.__name__.replace("_", "-"): info.callback
        for info in app.registered_commands
        if info.callback is not None
    }
    return {name: functions[name] for name in COMMANDS if name in functions}


@cache
def parameters_of(name: str) -> dict[str, Parameter]:
    """Return the parameters of a tool by their names for agents."""
    made = dict[str, Parameter]()
    for key, parameter in signature(commands()[name], eval_str=True).parameters.items():
        annotation, info = get_args(parameter.annotation)[:2]
        # Of an annotated option, the first name stands where a default would.
        texts = [info.default, *(getattr(info, "param_decls", None) or ())]
        flags = [text for text in texts if isinstance(text, str) and text.startswith("--")]
        is_option = isinstance(info, OptionInfo)
        flag = "" if not is_option else flags[0] if flags else f"--{key.replace('_', '-')}"
        label = flag[2:].replace("-", "_") or key
        if label not in EXCLUDED:
            plain = _without_none(annotation)
            is_list = get_origin(plain) is list
            value = get_args(plain)[0] if is_list else plain
            made[label] = Parameter(value, is_list, parameter.default is Signature.empty, info, flag)
    return made


def _without_none(annotation: Any) -> Any:
    """Return the type of values of `TYPE | None`."""
    types = [each for each in get_args(annotation) if each is not NoneType]
    return types[0] if NoneType in get_args(annotation) else annotation


def tools() -> list[Tool]:
    """Return the tools with the JSON schemas of their arguments."""
    return [
        Tool(
            name=name,
            description=getdoc(function),
            input_schema=schema_of(name),
            annotations=ToolAnnotations(
                read_only_hint=name in READING,
                destructive_hint=False,
                idempotent_hint=name in READING,
                open_world_hint=False,
            ),
        )
        for name, function in commands().items()
    ]


def schema_of(name: str) -> dict[str, Any]:
    """Return the JSON schema of a tool's arguments."""
    parameters = parameters_of(name)
    return {
        "type": "object",
        "properties": {label: parameter.schema for label, parameter in parameters.items()},
        "required": [label for label, parameter in parameters.items() if parameter.is_required],
        "additionalProperties": False,
    }


def command_line(name: str, given: Mapping[str, Any], root: Path) -> list[str]:
    """Return the arguments of `tuner` for a call of a tool.

    Args:
        name: of the tool.
        given: arguments of the call, by the names of its schema.
        root: folder that files have to lie in.

    Raises:
        InputError: there is no such tool or argument, or a file lies elsewhere.
    """
    if name not in commands():
        raise InputError(f"there is no tool {name!r}; there are {', '.join(commands())}")
    parameters = parameters_of(name)
    if unknown := sorted(given.keys() - parameters.keys()):
        raise InputError(f"there is no such argument; allowed are {', '.join(parameters)}", key=unknown[0])
    options, arguments = list[str](), list[str]()
    for label, parameter in parameters.items():
        value = given.get(label)
        if value is None or value is False:
            if parameter.is_required:
                raise InputError("is missing", key=label)
            continue
        if isinstance(value, list) is not parameter.is_list:
            raise InputError(f"must be {'a list' if parameter.is_list else 'one value'}", key=label)
        if parameter.type is bool:
            options.append(parameter.flag)
            continue
        texts = [_text(each, label, parameter, root) for each in (value if isinstance(value, list) else [value])]
        if parameter.flag:
            options += [f"{parameter.flag}={text}" for text in texts]
        else:
            arguments += texts
    return [name, *options, "--json", "--", *arguments]


def _text(value: Any, label: str, parameter: Parameter, root: Path) -> str:
    """Return a value as the command line takes it."""
    if not isinstance(value, str | int | float):
        raise InputError(f"given a {type(value).__name__}; it must be a text or a number", key=label)
    text = str(value)
    if len(text) > MOST_LETTERS or "\0" in text:
        raise InputError(f"must be a text of at most {MOST_LETTERS} letters", key=label)
    if not parameter.flag and text.startswith("-"):
        raise InputError(f"given {text!r}; write ./{text} for a file whose name begins with '-'", key=label)
    _check_place(text.partition("=")[2] or text, label, root)
    return text


def _check_place(text: str, label: str, root: Path) -> None:
    """Raise InputError where a text names a file outside of the root."""
    if not (root / text).resolve().is_relative_to(root.resolve()) or text.startswith("~"):
        raise InputError(f"given {text!r}, which lies outside of {root}; name a file in that folder", key=label)


def exit_meaning(code: int) -> str:
    """Return the meaning of an exit code."""
    meanings: Sequence[str] = (
        "done",
        "done; a limit is violated or a difference is there",
        "refused: bad input",
        "done; nothing feasible",
    )
    return meanings[code] if 0 <= code < len(meanings) else "ended before it was done"
