"""The application: its help in groups, its version, and the names that it resolves and completes."""

from collections.abc import Callable, Collection, Iterable
from enum import Enum
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

import tuner as package
from plant.errors import InputError
from plant.texts import PlainTable, toml_table
from tuner.experiments.options import THREADS, RunOption
from tuner.extension import extensions, refuse_lacking
from tuner.text.pairs import named_number, named_text
from tuner.text.signals import CRASHED

CODE = "--code"
"""Option that names a file of the user's own code, of every command."""
# Of the click that typer brings along.
USAGE_ERROR: Any = typer.BadParameter.__base__
# Letters of a command's first sentence that its line in the help may have.
SENTENCE = 200

EVERYDAY = (
    "new", "check", "run", "show", "compare", "fly", "margins", "export", "judge", "autotune", "report", "list",
)  # fmt: skip
"""Commands that stand first in the help, in the order of a day's work."""
FURTHER = ("bench",)
"""Commands of extensions that stand behind those of the core."""


def command_groups(names: Collection[str]) -> dict[str, list[str]]:
    """Return headings of the help with their commands, empty ones left out."""
    homes = {command: record.name for record in extensions().values() for command in record.commands}
    placed = {*EVERYDAY, *FURTHER}
    groups = {
        "Every day": [name for name in EVERYDAY if name in names],
        "Further": [
            *(name for name in names if name not in homes.keys() | placed),
            *(name for name in FURTHER if name in names),
        ],
        "Of extensions": sorted((homes.keys() - placed).intersection(names), key=lambda name: (homes[name], name)),
    }
    return {heading: below for heading, below in groups.items() if below}


class TextKind(Enum):
    """Kind of a text parameter, as metadata of its type; a text without one is a name, a file or a folder."""

    LOG = "FILE, or FILE@BEGIN:END for a part"
    CHANGE = "KEY=VALUE, whose value may name files"


class GroupedCommands(TyperGroup):
    """Command group of `tuner`, whose help lists the commands below headings.

    Each has the first sentence of its help.
    """

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write a section for each group."""
        longest = max(map(len, self.commands))
        for heading, names in command_groups(self.commands).items():
            sentences = [self.commands[name].get_short_help_str(limit=SENTENCE) for name in names]
            with formatter.section(heading):
                formatter.write_dl(list(zip([name.ljust(longest) for name in names], sentences, strict=True)))

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the command of the first argument; InputError where it comes with an extension that is not installed."""
        if args[0] not in self.commands:
            refuse_lacking("commands", args[0])
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Carry out a command; an error of an option names its valid values."""
        try:
            return super().invoke(ctx)
        except USAGE_ERROR as error:
            params = self.commands[ctx.invoked_subcommand].params if ctx.invoked_subcommand in self.commands else []
            given = getattr(error, "option_name", None)
            helps = [getattr(param, "help", None) for param in params if given in param.opts]
            error.message = " ".join([error.message, *filter(None, helps)])
            raise


def print_version(is_given: bool) -> None:
    """Print the version and end, where it is asked for."""
    if is_given:
        typer.echo(package.__version__)
        raise typer.Exit


app = typer.Typer(
    name="tuner",
    cls=GroupedCommands,
    help="Tune controller gains of multirotors and other plants.\n\nExample: tuner run quickstart",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    epilog="Every command has --help with an example. --debug shows the traceback of an error. "
    f"Exit codes are in the help of each command; {CRASHED} is a defect of the tool and no verdict.",
)


@app.callback()
def tuner(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and exit.", callback=print_version, is_eager=True)
    ] = False,
    code: Annotated[
        list[Path] | None,
        typer.Option(
            CODE,
            help="Run your own law, metric, reference or plant first: its file, or a study that names it; may stand last.",
            show_default=False,
        ),
    ] = None,
) -> None:
    """Take the options that stand before a command."""
    if code:
        from tuner.study.own_code import use_named

        for file in code:
            use_named(file)


def with_code_first(arguments: list[str]) -> list[str]:
    """Return the command line's arguments with every --code FILE before the command."""
    code, others, rest = list[str](), list[str](), iter(arguments)
    for argument in rest:
        if argument == CODE:
            code += [argument, *islice(rest, 1)]
        else:
            (code if argument.startswith(f"{CODE}=") else others).append(argument)
    return [*code, *others]


def beginning(names: Callable[[], Iterable[str]]) -> Callable[[str], list[str]]:
    """Return a completion by names; they are asked for when somebody completes."""

    def complete(incomplete: str) -> list[str]:
        return [name for name in names() if name.startswith(incomplete)]

    return complete


def studies() -> list[str]:
    """Return the names of shipped studies and of this folder's TOML files."""
    from tuner.study.files import shipped_studies

    return [*shipped_studies(), *sorted(path.name for path in Path().glob("*.toml"))]


def found_study(given: Path | None) -> Path | None:
    """Return the file of a study, given by path or name.

    A wrong name is reported before anything else is imported.
    """
    from tuner.study.files import study_file

    return None if given is None else study_file(given)


def completions(kind: str) -> list[str]:
    """Return the names of a kind of `tuner list`, or those kinds."""
    from tuner.api.catalogue import listings, names_of

    return names_of(kind) if kind else list(listings())


def schemas() -> list[str]:
    """Return the names of the schemas that `tuner schema` prints."""
    from tuner.documents.registry import schema_names

    return schema_names()


# Completions of what an argument or an option takes.
SCHEMA = beginning(schemas)
STUDY = beginning(studies)
LAW, AIRFRAME, TARGET, SOURCE, FIRMWARE, LISTING = (
    beginning(partial(completions, kind)) for kind in ("laws", "airframes", "targets", "sources", "firmwares", "")
)


def study_option(about: str, *names: str) -> Any:
    """Return an option that takes a study; names: as it is called, by default as its parameter."""
    return typer.Option(*names, help=about, callback=found_study, autocompletion=STUDY)


def law_option(about: str) -> Any:
    """Return an option that takes the name of a law."""
    return typer.Option(help=about, autocompletion=LAW)


def option_of(name: str, _: Any, option: RunOption) -> Any:
    """Return the parameter of an option of experiments on the command line."""
    return Annotated[option.type, typer.Option(option.flag_of(name), help=option.help, min=option.least)]


# Arguments and options that several commands share.
StudyFile = Annotated[
    Path,
    typer.Argument(
        help="Study: a file (TOML), or a name that `tuner list studies` shows.",
        show_default=False,
        callback=found_study,
        autocompletion=STUDY,
    ),
]
Folder = Annotated[Path, typer.Argument(help="A results folder.", show_default=False)]
GainsFile = Annotated[Path, typer.Argument(help="A gains.json.", show_default=False)]
Threads = Annotated[int | None, typer.Option(help=THREADS.help, min=THREADS.least)]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON only.")]
GivenGains = Annotated[Path | None, typer.Argument(help="A gains.json, or a study for its default.")]
FlownLaw = Annotated[str | None, law_option("Attitude law to fly with its default gains.")]
PositionLaw = Annotated[str, law_option("Position law, with --law.")]
Airframe = Annotated[str | None, typer.Option(help="Airframe: a bundled name or a TOML file.", autocompletion=AIRFRAME)]
FlownStudy = Annotated[Path | None, study_option("Fly a scenario of this study.")]
ScenarioNumber = Annotated[int, typer.Option(help="Which scenario of the study, from 0.", min=0)]
Gain = Annotated[
    list[str] | None, typer.Option(metavar="NAME=VALUE", help="Another value of a gain; give it again for others.")
]
Seeds = Annotated[int | None, typer.Option(help="Flights of each scenario; by default the study's held_out.", min=2)]


def target_options(change: list[str] | None, firmware: str | None) -> list[str]:
    """Return --set and --firmware as NAME=VALUE texts."""
    return [*(change or []), *([] if firmware is None else [f"firmware={firmware}"])]


def gains_of(change: list[str] | None) -> dict[str, float]:
    """Return the values of --gain by name."""
    return dict(named_number(text, "--gain", "roll.kp=12") for text in change or [])


def set_option(about: str) -> Any:
    """Return an option --set that may be repeated."""
    return typer.Option("--set", help=about)


Changes = Annotated[list[str] | None, TextKind.CHANGE]
StudyChanges = Annotated[Changes, set_option("KEY=VALUE: override a value of the study; repeatable.")]
TargetChanges = Annotated[Changes, set_option("NAME=VALUE: an option of the target.")]
SourceChanges = Annotated[Changes, set_option("NAME=VALUE: an option of the source.")]


def parse_changes(given: list[str] | None) -> PlainTable:
    """Turn KEY=VALUE texts into values; a value is read as TOML, and as plain text where it is none."""
    parsed: PlainTable = {}
    for change in given or []:
        key, text = named_text(change, "--set", "search.generations=3", "KEY=VALUE")
        try:
            parsed[key] = toml_table(f"value = {text}", Path("--set"))["value"]
        except InputError:
            parsed[key] = text
    return parsed
