"""The person's side: command line, study files, search, results folders, report."""

from importlib.util import find_spec
from pathlib import Path


def _check_neighbours() -> None:
    """Raise ImportError where a file of the user's own stands on the import path before a package of ours."""
    home = Path(__file__).resolve().parents[1]
    for package in ("plant", "objectives"):
        spec = find_spec(package)
        found = None if spec is None or spec.origin is None else Path(spec.origin).resolve()
        if found is not None and found.parent.parent == home:
            continue
        if found is None:
            told = f"the package '{package}' of holdfast is missing from {home}; install holdfast again"
        else:
            told = f"{found} hides the package '{package}' of holdfast; rename that file, or start in another folder"
        # With the name of what could not be imported, `python -m tuner` tells it in one line.
        raise ImportError(told, name=__name__)


_check_neighbours()


def __getattr__(name: str) -> str:
    """Return __version__ of the installed package, read when it is first asked for: the metadata take 20 ms to import."""
    if name != "__version__":
        raise AttributeError(f"module 'tuner' has no attribute '{name}'")
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("holdfast")
    except PackageNotFoundError:
        return "not installed"
