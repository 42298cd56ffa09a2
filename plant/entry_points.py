"""Entry points of installed packages, and the files behind them.

`importlib.metadata` would find the same; its import takes 25 ms, a third of `tuner --help`.
"""

import os
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

DISTRIBUTION = "gainproof"
"""Name of this tool's own distribution."""
LAW_GROUP = "gainproof.laws"
"""Group of entry points that name laws."""
METRIC_GROUP = "gainproof.metrics"
"""Group of entry points that name metrics."""
FLIGHT_CODE = "gainproof.flight_code"
"""Group of entry points that name modules and packages outside of `plant` whose code flies."""


def entry_points(group: str, places: list[str], distribution: str = "") -> Iterator[tuple[str, str]]:
    """Return name and value of each entry point of a group.

    Args:
        group: Name of the group.
        places: Folders of packages, such as `sys.path`; the first of distributions of one name counts.
        distribution: Name of the only distribution that is read, "" for all.
    """
    seen = set[str]()
    for place in places:
        for folder in _distributions(Path(place)):
            name, file = folder.name.partition("-")[0], folder / "entry_points.txt"
            if name in seen or distribution not in ("", name):
                continue
            text = file.read_text(encoding="utf-8") if file.is_file() else ""
            if f"[{group}]" not in text:
                continue
            seen.add(name)
            section = text.partition(f"[{group}]")[2].partition("\n[")[0]
            for line in filter(None, map(str.strip, section.splitlines())):
                key, _, value = line.partition("=")
                yield key.strip(), value.strip()


def _distributions(place: Path) -> list[Path]:
    """Return the folders of metadata of the packages in a folder."""
    return [place / name for name in sorted(os.listdir(place)) if name.endswith(".dist-info")] if place.is_dir() else []


def files_of(module: str) -> dict[str, Path]:
    """Return the files of a package or module by their paths.

    Args:
        module: Dotted name of one that is installed.
    """
    spec = find_spec(module)
    assert spec is not None and spec.origin is not None, module
    home = Path(spec.origin)
    files = sorted(home.parent.rglob("*.py")) if spec.submodule_search_locations else [home]
    return {file.relative_to(home.parent).as_posix(): file for file in files}
