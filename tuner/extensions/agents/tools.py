"""Tools of an agent: each is a command of `tuner`, with the command's own arguments, help and answer."""

from collections.abc import Callable, Iterator, Mapping
from enum import Enum
from functools import cache
from inspect import Signature, getdoc, signature
from pathlib import Path
from types import NoneType
from typing import Any, NamedTuple, get_args, get_origin

from mcp.types import Tool, ToolAnnotations
from typer.models import OptionInfo, ParameterInfo

from plant.errors import InputError
from tuner.cli.app import TextKind, app
from tuner.extensions.agents.places import check_place, check_text

EXCLUDED = frozenset({"json", "threads", "dask", "backend", "live"})
"""Options that concern the terminal or the machine."""
TYPES = {bool: "boolean", int: "integer", float: "number"}
"""Types of the command line -> types of JSON; all others are texts."""
MAX_LETTERS = 4096
"""Letters of one text."""
MAX_LETTERS_OF_CALL = 100_000
"""Letters of all texts of a call."""
RESULTS = "results"
"""Folder of runs without --out, below the root."""


class Effect(Enum):
    """Effect of a tool on the files below the root."""

    READ = "reads files"
    NEW = "writes new files, replaces none"
    CHANGE = "writes new files, and replaces some of its own"


class ToolRow(NamedTuple):
    """Row of the table of tools.

    Attributes:
        effect: on files.
        unnamed: places that a call writes without naming them, by its arguments.
    """

    effect: Effect
    unnamed: Callable[[Mapping[str, Any]], list[Path]] = lambda given: []


TOOLS = {
    "list": ToolRow(Effect.READ),
    "new": ToolRow(Effect.NEW, lambda given: [Path(given.get("out") or ".", str(given["name"]))]),
    "check": ToolRow(Effect.READ),
    "plan": ToolRow(Effect.READ),
    "design": ToolRow(Effect.NEW),
    "import": ToolRow(Effect.NEW),
    "identify": ToolRow(Effect.NEW),
    "autotune": ToolRow(Effect.CHANGE),
    "run": ToolRow(Effect.NEW, lambda given: [] if given.get("out") else [Path(RESULTS)]),
    "resume": ToolRow(Effect.CHANGE),
    "rejudge": ToolRow(Effect.NEW),
    "show": ToolRow(Effect.READ),
    "compare": ToolRow(Effect.NEW),
    "margins": ToolRow(Effect.NEW),
    "fly": ToolRow(Effect.CHANGE),
    "judge": ToolRow(Effect.NEW),
    "tail": ToolRow(Effect.CHANGE),
    "export": ToolRow(Effect.NEW, lambda given: [Path(str(given["gains"])).parent / "export"]),
}
"""Commands that agents may call. None of them speaks to a vehicle."""


class Parameter(NamedTuple):
    """A parameter of a command.

    Attributes:
        type: type of a value.
        kind: kind of a text, None for a name or a place.
        is_list: whether it takes several values.
        default: its default, `Signature.empty` where a value is required.
        info: its description for the command line.
        flag: flag of an option, empty for an argument.
    """

    type: type
    kind: TextKind | None
    is_list: bool
    default: Any
    info: Any
    flag: str

    @property
    def is_required(self) -> bool:
        """Whether a call has to give it."""
        return self.default is Signature.empty

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
    return {name: functions[name] for name in TOOLS}


@cache
def parameters_of(name: str) -> dict[str, Parameter]:
    """Return the parameters of a tool by their names for agents."""
    made = dict[str, Parameter]()
    for key, parameter in signature(commands()[name], eval_str=True).parameters.items():
        annotation, *metadata = get_args(parameter.annotation)
        (info,) = [each for each in metadata if isinstance(each, ParameterInfo)]
        kind = next((each for each in metadata if isinstance(each, TextKind)), None)
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
            made[label] = Parameter(value, kind, is_list, parameter.default, info, flag)
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
                read_only_hint=TOOLS[name].effect is Effect.READ,
                destructive_hint=TOOLS[name].effect is Effect.CHANGE,
                idempotent_hint=TOOLS[name].effect is Effect.READ,
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
        name: name of the tool.
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
    options, arguments, skipped = list[str](), list[str](), ""
    for label, parameter in parameters.items():
        texts = _texts(given.get(label), label, parameter)
        if not texts and not parameter.flag:
            skipped = skipped or label
        elif parameter.type is bool:
            options += [parameter.flag for text in texts if text == "True"]
        elif parameter.flag:
            options += [f"{parameter.flag}={text}" for text in texts]
        elif skipped:
            raise InputError(f"is missing; {label} needs it", key=skipped)
        else:
            arguments += texts
    _check_places(name, given, root.resolve())
    if sum(map(len, [*options, *arguments])) > MAX_LETTERS_OF_CALL:
        raise InputError(f"the arguments have more than {MAX_LETTERS_OF_CALL:,} letters; write them to a file")
    return [name, *options, "--json", "--", *arguments]


def _texts(given: Any, label: str, parameter: Parameter) -> list[str]:
    """Return the texts of an argument: none where it is left out."""
    if given is None or given == []:
        if parameter.is_required:
            raise InputError("is missing", key=label)
        return []
    if isinstance(given, list) is not parameter.is_list:
        raise InputError(f"must be {'a list' if parameter.is_list else 'one value'}", key=label)
    return [_text(value, label, parameter) for value in (given if isinstance(given, list) else [given])]


def _text(value: Any, label: str, parameter: Parameter) -> str:
    """Return a value as the command line takes it."""
    if not isinstance(value, str | int | float):
        raise InputError(f"given a {type(value).__name__}; it must be a text or a number", key=label)
    if isinstance(value, bool) is not (parameter.type is bool):
        raise InputError(f"given {value!r}; it must be {TYPES.get(parameter.type, 'string')}", key=label)
    text = str(value)
    if len(text) > MAX_LETTERS or "\0" in text or any("\ud800" <= letter <= "\udfff" for letter in text):
        raise InputError(f"must be a text of at most {MAX_LETTERS} letters of Unicode", key=label)
    if not parameter.flag and text.startswith("-"):
        raise InputError(f"given {text!r}; write ./{text} for a file whose name begins with '-'", key=label)
    return text


def _check_places(name: str, given: Mapping[str, Any], root: Path) -> None:
    """Raise InputError for a call that names a place outside."""
    bases = [base for text in _places(name, given) for base in (root / text, (root / text).parent)]
    for label, parameter in parameters_of(name).items():
        value = given.get(label)
        if value is None and isinstance(parameter.default, Path):
            value = str(parameter.default)
        if parameter.type in (str, Path):
            for text in value if isinstance(value, list) else [] if value is None else [value]:
                check_text(str(text), label, parameter.kind, root, bases)
    for place in TOOLS[name].unnamed(given):
        check_place(str(place), name, root)
        check_place(f"{place}.toml", name, root)


def _places(name: str, given: Mapping[str, Any]) -> Iterator[str]:
    """Yield the values of a call's parameters of type Path."""
    for label, parameter in parameters_of(name).items():
        value = given.get(label)
        if parameter.type is Path and value is not None:
            yield from value if isinstance(value, list) else [str(value)]
