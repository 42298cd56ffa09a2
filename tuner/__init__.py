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
from types import FunctionType
from typing import Any

_HOMES = {
    "plant.errors": ("InputError", "StoreError", "ToolError", "UnknownNameError"),
    "tuner.api.catalogue": ("catalogue",),
    "tuner.api.checking": ("check", "check_requirements", "validate"),
    "tuner.api.comparing": ("compare",),
    "tuner.api.designing": ("design",),
    "tuner.api.exporting": ("export", "import_gains"),
    "tuner.api.flying": ("fly",),
    "tuner.api.gains": ("Gains", "default_gains", "read_gains"),
    "tuner.api.margins": ("margins",),
    "tuner.api.planning": ("plan",),
    "tuner.api.results": (
        "ComparisonResults",
        "Results",
        "TuningResults",
        "open_results",
        "read_table",
    ),
    "tuner.api.runs": ("rejudge", "resume", "run", "verify"),
    "tuner.api.studies": ("PlantStudy", "Study", "load_study", "make_study"),
    "tuner.search.watcher": ("Watcher",),
    "tuner.study.own_code": ("use",),
}
"""Module of the core -> its public names; those of extensions are in their records."""


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
    """Import a public name when it is first used; return __version__ or __all__."""
    if name == "__all__":
        return public_names()
    if name == "__version__":
        from tuner.text.version import version

        return version()
    for home, names in _HOMES.items():
        if name in names:
            return _public(name, getattr(import_module(home), name))
    from tuner.extension import added, load

    reference = added("api").get(name)
    if reference is None:
        raise AttributeError(f"module 'tuner' has no attribute '{name}'")
    return _public(name, load(reference))


def _public(name: str, value: Any) -> Any:
    """Keep a public value under its name and return it; arguments of functions are checked."""
    if isinstance(value, FunctionType):
        from tuner.api.border import checked

        value = checked(value)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*public_names(), "__version__"])


def public_names() -> list[str]:
    """Return the public names of the core and of all extensions."""
    from tuner.extension import added

    return sorted([*(name for names in _HOMES.values() for name in names), *added("api")])
