"""Options of experiments: what `run` and `resume` take in Python and on the command line, each written down here once.

An option is read where it is used, from `Experiment.options`. This module imports quickly: the command line is built from it.
"""

import inspect
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple, TypedDict, TypeVar, get_args, get_type_hints

Function = TypeVar("Function", bound=Callable[..., Any])
# Stands in a docstring for the options.
PLACE = "**options: Options as of the command line."


class RunOption(NamedTuple):
    """An option of a run.

    Attributes:
        type: Type as the command line gives it.
        why: Reason with which kinds that do not take it refuse it, None where all take it.
        least: Smallest number allowed.
        flag: Flag on the command line, by default the name.
    """

    type: Any
    help: str
    why: str | None = None
    default: Any = None
    least: int | None = None
    flag: str | None = None

    def flag_of(self, name: str) -> str:
        """Return the flag of the option with this name."""
        return f"--{self.flag or name.replace('_', '-')}"


THREADS = RunOption(int | None, "Number of threads; default: one per core.", least=1)
DASK = RunOption(
    str | None,
    "Run on a Dask cluster: local:N, or tcp://host:8786.",
    "only a tuning study flies on a cluster",
)
REUSE = RunOption(
    list[Path] | None,
    "Reuse identical flights of another results folder; repeatable.",
    "only a tuning study takes flights over",
)
BACKEND = RunOption(
    str,
    "Simulation backend: lanes (processor), cuda (graphics card) or cuda-float32.",
    "only a tuning study flies on a graphics card",
    "lanes",
)
BUDGET = RunOption(
    int | None,
    "Total generations; more than before extends the search.",
    "only a tuning study can be searched further; run this one with another search.generations",
    least=1,
)
SEARCH_FLIGHTS = RunOption(
    int | None,
    "Flights of each scenario in the search; more than before: the search goes on from where they change it.",
    "only a tuning study makes more flights; run this one with another scenario.0.search",
    least=1,
)
RECOMPUTE = RunOption(
    bool,
    "Recompute a run of another machine in this machine's arithmetic.",
    "only a tuning study can be recomputed; run this one again",
    default=False,
    flag="here",
)


class RunOptions(TypedDict, total=False):
    """Options of `run`, in the order of its help."""

    threads: Annotated[int | None, THREADS]
    reuse: Annotated[Sequence[str | Path] | None, REUSE]
    dask: Annotated[str | None, DASK]
    backend: Annotated[str, BACKEND]


class ResumeOptions(TypedDict, total=False):
    """Options of `resume`, in the order of its help."""

    budget: Annotated[int | None, BUDGET]
    search_flights: Annotated[int | None, SEARCH_FLIGHTS]
    threads: Annotated[int | None, THREADS]
    dask: Annotated[str | None, DASK]
    recompute: Annotated[bool, RECOMPUTE]


class Options(RunOptions, ResumeOptions, total=False):
    """Options that an experiment may hold."""


def hints_of(form: type) -> dict[str, tuple[Any, RunOption]]:
    """Return the options of a form above by name, with Python types."""
    return {name: get_args(hint) for name, hint in get_type_hints(form, include_extras=True).items()}


OPTIONS = {name: option for name, (_, option) in hints_of(Options).items()}
"""Options by name."""


def reused(options: Options | RunOptions) -> tuple[Path, ...]:
    """Return the results folders whose flights are taken over."""
    return tuple(map(Path, options.get("reuse") or ()))


def with_options(form: type, annotate: Callable[[str, Any, RunOption], Any]) -> Callable[[Function], Function]:
    """Return a decorator that adds a form's options to signature and docstring.

    The function says `**options`. They come before the last of its other parameters; those that it names itself stay
    where they are. annotate: gives the type to be shown, from the name, the type in Python and the option.
    """

    def write(function: Function) -> Function:
        given = inspect.signature(function)
        *first, last, _ = given.parameters.values()
        options = {name: hint for name, hint in hints_of(form).items() if name not in given.parameters}
        added = [
            inspect.Parameter(name, last.kind, default=option.default, annotation=annotate(name, hint, option))
            for name, (hint, option) in options.items()
        ]
        vars(function)["__signature__"] = given.replace(parameters=[*first, *added, last])
        lines = (f"{name}: {option.help}{' Tuning only.' * bool(option.why)}" for name, (_, option) in options.items())
        function.__doc__ = (function.__doc__ or "").replace(PLACE, ("\n" + " " * 8).join(lines))
        return function

    return write
