"""Tune quadrotor controllers so that their gains hold in turbulence.

    >>> import tuner
    >>> study = tuner.load_study("quickstart", {"search.generations": 20})
    >>> results = tuner.run(study, "results/first")  # doctest: +SKIP
    >>> results.front, results.recommended  # doctest: +SKIP

The names below are the public interface; everything else in this package may change without notice. A name is imported when
it is first asked for, because compilers and plotting libraries take seconds to load.
"""

from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from plant.errors import InputError, StoreError, ToolError, UnknownNameError
    from tuner.api.approaching import approach
    from tuner.api.autotuning import autotune
    from tuner.api.catalogue import catalogue
    from tuner.api.checking import check, check_requirements, validate
    from tuner.api.comparing import compare
    from tuner.api.comparing_logs import compare_logs
    from tuner.api.confirming import confirm
    from tuner.api.designing import design
    from tuner.api.estimating import estimate_airframe
    from tuner.api.exporting import export, import_gains
    from tuner.api.flight_plans import plan_flight
    from tuner.api.flying import fly
    from tuner.api.gains import Gains, default_gains, read_gains
    from tuner.api.identifying import check_logs, identify
    from tuner.api.judging import judge, read_back
    from tuner.api.margins import cost, margins, theory
    from tuner.api.planning import plan
    from tuner.api.results import (
        ComparisonResults,
        ContestResults,
        Results,
        TuningResults,
        open_results,
        read_table,
    )
    from tuner.api.runs import rejudge, resume, run, verify
    from tuner.api.studies import PlantStudy, Study, load_study, make_study
    from tuner.api.tails import tail
    from tuner.api.trials import ask, tell
    from tuner.extensions.sensitivity.api import sensitivity
    from tuner.search.watcher import Watcher
    from tuner.study.own_code import use

    __version__: str

__all__ = [
    "ComparisonResults", "ContestResults", "Gains", "InputError", "PlantStudy", "Results", "StoreError",
    "Study", "ToolError", "TuningResults", "UnknownNameError", "Watcher", "approach", "ask", "autotune", "catalogue",
    "check", "check_logs", "check_requirements", "compare", "compare_logs", "confirm", "cost", "default_gains", "design",
    "estimate_airframe", "export", "fly", "identify", "import_gains", "judge", "load_study", "make_study", "margins",
    "open_results", "plan", "plan_flight", "read_back", "read_gains", "read_table", "rejudge", "resume", "run", "sensitivity",
    "tail", "tell", "theory", "use", "validate", "verify",
]  # fmt: skip

_HOMES = {
    "plant.errors": ("InputError", "StoreError", "ToolError", "UnknownNameError"),
    "tuner.api.approaching": ("approach",),
    "tuner.api.autotuning": ("autotune",),
    "tuner.api.catalogue": ("catalogue",),
    "tuner.api.checking": ("check", "check_requirements", "validate"),
    "tuner.api.comparing": ("compare",),
    "tuner.api.comparing_logs": ("compare_logs",),
    "tuner.api.confirming": ("confirm",),
    "tuner.api.designing": ("design",),
    "tuner.api.estimating": ("estimate_airframe",),
    "tuner.api.exporting": ("export", "import_gains"),
    "tuner.api.flight_plans": ("plan_flight",),
    "tuner.api.flying": ("fly",),
    "tuner.api.gains": ("Gains", "default_gains", "read_gains"),
    "tuner.api.identifying": ("check_logs", "identify"),
    "tuner.api.judging": ("judge", "read_back"),
    "tuner.api.margins": ("cost", "margins", "theory"),
    "tuner.api.planning": ("plan",),
    "tuner.api.results": (
        "ComparisonResults",
        "ContestResults",
        "Results",
        "TuningResults",
        "open_results",
        "read_table",
    ),
    "tuner.api.runs": ("rejudge", "resume", "run", "verify"),
    "tuner.api.studies": ("PlantStudy", "Study", "load_study", "make_study"),
    "tuner.api.tails": ("tail",),
    "tuner.api.trials": ("ask", "tell"),
    "tuner.search.watcher": ("Watcher",),
    "tuner.study.own_code": ("use",),
}
"""Module -> its public names."""


def _check_neighbours() -> None:
    """Raise ImportError where a file of the user's own stands on the import path before a package of ours."""
    home = Path(__file__).resolve().parents[1]
    for package in ("plant", "objectives"):
        spec = find_spec(package)
        home_found = None if spec is None or spec.origin is None else Path(spec.origin).resolve()
        if home_found is not None and home_found.parent.parent == home:
            continue
        if home_found is None:
            message = f"the package '{package}' of gainproof is missing from {home}; install gainproof again"
        else:
            message = (
                f"{home_found} hides the package '{package}' of gainproof; rename that file, or start in another folder"
            )
        # With the name of what could not be imported, `python -m tuner` tells it in one line.
        raise ImportError(message, name=__name__)


_check_neighbours()


def __getattr__(name: str) -> Any:
    """Import a public name when it is first asked for, or return __version__."""
    if name == "__version__":
        from tuner.text.version import version

        return version()
    for home, names in _HOMES.items():
        if name in names:
            value = getattr(import_module(home), name)
            globals()[name] = value
            return value
    from tuner.extension import added, load

    reference = added("api").get(name)
    if reference is None:
        raise AttributeError(f"module 'tuner' has no attribute '{name}'")
    value = globals()[name] = load(reference)
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
