"""`python -m benchmarks.search.shipped_fronts`: make the fronts that come with the tool, for pairs of general laws; an hour.

Each pair is tuned in the flights and limits of the quickstart, with the usual ranges of those gains of both laws that studies
search; the others have their defaults. Points are those of the front that add most to its hypervolume. Pairs that are in the
file stay as they are; `--again` goes on from them.
"""

import argparse
import json
from collections.abc import Iterable, Iterator
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.search.problems import ROOT
from plant.law_registry import law
from tuner.experiments.tuning.run import TuningRun
from tuner.search.loop import archive
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder
from tuner.study.build import load_study
from tuner.study.shipped_fronts import FILE

LAWS = ("hybrid", "ladrc", "pid", "adrc", "supertwisting")
POINTS, DIGITS = 24, 5
# Gains that studies leave at their defaults: widths of linear zones, the acceleration of a set point, filters.
LEFT = ("delta", "delta_0", "delta_1", "delta_2", "r_0", "t_f")
# As many flights as a front needs that holds in others, and a seed that no benchmark has.
SIZES = {
    "seed": 1,
    "scenario.0.search": 64,
    "search.first": 64,
    "search.population": 20,
    "search.generations": 24,
}


def gains_of(attitude: str, position: str) -> dict[str, dict[str, float]]:
    """Return the [gains] table that searches gains of two laws, the same in all axes of a loop."""
    loops = {"attitude": attitude, "position": position}
    return {
        f"{loop}.{gain.name.rstrip('_')}": {}
        for loop, name in loops.items()
        for gain in law(name).gains
        if gain.name not in LEFT
    }


def points_of(attitude: str, position: str) -> list[dict[str, float]]:
    """Return the points of a pair's front, those that add most first; none where no candidate keeps the limits.

    Of 256 held-out flights one may be beyond every candidate, so that none is recommended: the front is one all the same.
    """
    laws = {"controller.attitude": attitude, "controller.position": position, "gains": gains_of(attitude, position)}
    study = load_study(ROOT / "studies/quickstart.toml", {**SIZES, **laws})
    with TemporaryDirectory() as scratch:
        folder = Path(scratch) / "run"
        outcome = TuningRun(study, Folder.create(folder), Watcher()).carry_out()
        if not len(archive(outcome.generations).front()):
            return []
        again = load_study(study.path, {**SIZES, **laws, "search.starts": [str(folder)]})
    return [rounded(point) for point in again.search.starts[0].points[:POINTS]]


def rounded(point: Any) -> dict[str, float]:
    """Return the gains of a point in a few digits."""
    return {name: float(f"{value:.{DIGITS}g}") for name, value in point.items()}


def made(pairs: Iterable[tuple[str, str]]) -> Iterator[dict[str, Any]]:
    """Yield the fronts of pairs of laws."""
    for attitude, position in pairs:
        points = points_of(attitude, position)
        print(attitude, position, len(points), flush=True)
        if points:
            yield {"attitude": attitude, "position": position, "points": points}


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--again", action="store_true", help="search on from those that the file has")
    again = parser.parse_args().again
    fronts = {(entry["attitude"], entry["position"]): entry for entry in json.loads(FILE.read_text())["fronts"]}
    pairs = list(fronts) if again else [pair for pair in product(LAWS, LAWS) if pair not in fronts]
    for front in made(pairs):
        fronts[front["attitude"], front["position"]] = front
        FILE.write_text(text_of(list(fronts.values())), encoding="utf-8")


def text_of(fronts: list[dict[str, Any]]) -> str:
    """Return the file: one point a line."""
    entries = ",\n".join(_entry(front) for front in fronts)
    return f'{{"airframe": "hummingbird", "study": "quickstart", "fronts": [\n{entries}\n]}}\n'


def _entry(front: dict[str, Any]) -> str:
    points = ",\n  ".join(json.dumps(point) for point in front["points"])
    return f'{{"attitude": "{front["attitude"]}", "position": "{front["position"]}", "points": [\n  {points}]}}'


if __name__ == "__main__":
    main()
