"""`python -m benchmarks.studies BEFORE`: every shipped study by an earlier revision and by this one, time and held-out result.

BEFORE is a worktree of the earlier revision. Each study is run by three variants: "before", tool and file of that revision; "its
search", this tool and file, searched as that revision does; "now". All fronts are flown by this revision's model on one and the
same stream, which no run of them has seen. The second tells what the search is worth where the file's air changed too. Runs that
the document has are kept; a study that fixes all gains has times only.
"""

import argparse
import csv
import json
import os
import resource
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from benchmarks.measuring import RESULTS, ElapsedTimes, machine, write_json
from benchmarks.search.problems import ROOT, SLACK
from objectives.problem import Evaluation
from plant.quadrotor.scenarios import CONFIRMATION
from tuner.experiments.compare.entrants import rows_of
from tuner.experiments.tuning.problem import batches, problem_of
from tuner.extensions.contests.study import Contest
from tuner.search.front import feasible_front, hypervolume
from tuner.study.kinds import load_any
from tuner.study.study import Study
from tuner.text.errors import NOTHING_FEASIBLE

VARIANTS = ("before", "its search", "now")
Run = dict[str, Any]


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path, help="a worktree of the earlier revision")
    parser.add_argument("--study", action="append", help="name of a study; all unless given")
    parser.add_argument("--out", type=Path, default=RESULTS / "studies.json")
    chosen = parser.parse_args()
    runs: list[Run] = json.loads(chosen.out.read_text(encoding="utf-8"))["runs"] if chosen.out.exists() else []
    for name in chosen.study or sorted(file.stem for file in (ROOT / "studies").glob("*.toml")):
        if not any(run["study"] == name for run in runs):
            runs += compared(name, chosen.before.resolve())
            write_json(
                chosen.out, {"machine": {**machine(), "command": "python -m benchmarks.studies BEFORE"}, "runs": runs}
            )
    text = markdown(runs)
    chosen.out.with_suffix(".md").write_text(text, encoding="utf-8")
    print(text)


def compared(name: str, before: Path) -> list[Run]:
    """Run a study by all variants and judge their fronts together."""
    found: list[Run] = []
    with tempfile.TemporaryDirectory() as folder:
        outs = {variant: Path(folder) / variant.replace(" ", "_") for variant in VARIANTS}
        for variant, (root, changes) in variants(name, before).items():
            if variant != "its search":
                # Two generations may find nothing that keeps the limits, which is no error here.
                run(
                    root, name, Path(folder) / f"warm_{outs[variant].name}", {**changes, "search.generations": 2}, False
                )
            spent = run(root, name, outs[variant], changes)
            found.append(
                {
                    "study": name,
                    "variant": variant,
                    "revision": revision(root),
                    "wall_seconds": spent.wall,
                    "processor_seconds": spent.busy,
                    "flights": flights_of(outs[variant]),
                }
            )
        for entry in found:
            entry["fronts"] = {}
        for label, study, part in judged(name):
            fronts = [outs[entry["variant"]] / part / "front.csv" for entry in found]
            for entry, worth in zip(found, worths(study, [gains_of(study, file) for file in fronts]), strict=True):
                entry["fronts"][label] = worth
    return found


def variants(name: str, before: Path) -> dict[str, tuple[Path, dict[str, Any]]]:
    """Return the variants of a study: the revision's folder, and what is changed in its file."""
    found: dict[str, tuple[Path, dict[str, Any]]] = {"before": (before, {})}
    study, changes = load_any(study_file(ROOT, name)), searched_by(before, name)
    if isinstance(study, Study) and {"gaussian_process", changes["search.algorithm"]} == {
        study.search.algorithm,
        "nsga2",
    }:
        found["its search"] = ROOT, changes
    return {**found, "now": (ROOT, {})}


def study_file(root: Path, name: str) -> Path:
    """Return the file of a shipped study in a revision's folder."""
    return root / "studies" / f"{name}.toml"


def searched_by(root: Path, name: str) -> dict[str, Any]:
    """Return what has the present file of a study searched as that of an earlier revision."""
    table = tomllib.loads(study_file(root, name).read_text(encoding="utf-8"))
    asked = table.get("search", {})
    changes = {f"search.{key}": asked[key] for key in ("population", "generations") if key in asked}
    changes |= {"search.algorithm": asked.get("algorithm", "nsga2"), "search.racing": asked.get("racing", True)}
    return changes | {f"scenario.{i}.search": entry["search"] for i, entry in enumerate(table.get("scenario", []))}


def run(root: Path, name: str, out: Path, changes: dict[str, Any], counts: bool = True) -> ElapsedTimes:
    """Run a study by the tool of a revision and return what it and all its processes take; counts: whether it must end well."""
    sets = [part for key, value in changes.items() for part in ("--set", f"{key}={json.dumps(value)}")]
    command = [sys.executable, "-m", "tuner", "run", str(study_file(root, name)), "--out", str(out), *sets]
    begin, wall = resource.getrusage(resource.RUSAGE_CHILDREN), perf_counter()
    done = subprocess.run(
        command, cwd=root, env={**os.environ, "PYTHONPATH": str(root)}, capture_output=True, text=True, check=False
    )
    wall, end = perf_counter() - wall, resource.getrusage(resource.RUSAGE_CHILDREN)
    # A contender that keeps no limits is a finding, too.
    if counts and done.returncode not in (0, NOTHING_FEASIBLE):
        sys.exit(f"{' '.join(command)}\n{done.stdout}{done.stderr}")
    return ElapsedTimes(wall, end.ru_utime + end.ru_stime - begin.ru_utime - begin.ru_stime)


def revision(root: Path) -> str:
    """Return the revision of a worktree."""
    return subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=root, check=True, capture_output=True, text=True
    ).stdout.strip()


def flights_of(out: Path) -> int | None:
    """Return the number of flights of a run as its documents tell it."""
    for file in ("contest.json", "summary.json"):
        if (out / file).exists():
            return json.loads((out / file).read_text(encoding="utf-8")).get("flights")
    return None


def judged(name: str) -> Iterator[tuple[str, Study, str]]:
    """Yield the tuning studies of a study that leave a front: a label, the study, and where in the results it lies."""
    study = load_any(study_file(ROOT, name))
    if isinstance(study, Study):
        yield "", study, "."
    elif isinstance(study, Contest):
        for entry in study.contenders:
            if entry.tuned and isinstance(entry.study, Study):
                yield entry.name, entry.study, f"contenders/{entry.slug}"


def gains_of(study: Study, file: Path) -> np.ndarray:
    """Return the gains rows (n, gains) of the points that a run's front holds: those that its held-out flights left there."""
    rows = list(csv.DictReader(file.read_text(encoding="utf-8").splitlines()))
    kept = [row for row in rows if row["non_dominated"] == row["feasible"] == "True"]
    names = [variable.name for variable in study.space.variables]
    return rows_of(
        study, np.array([[float(row[f"gain:{name}"]) for name in names] for row in kept]).reshape(-1, len(names))
    )


def worths(study: Study, fronts: list[np.ndarray]) -> list[dict[str, Any]]:
    """Return what fronts of gains rows (n, gains) are worth on flights that nobody's search has seen."""
    problem = problem_of(study, None, None)
    rows = np.concatenate([study.default_row[None], *fronts])
    found = problem.evaluate_gains(rows, batches(study, CONFIRMATION), fly_all=True)
    kept, ends = keeping(study, found), np.cumsum([1, *map(len, fronts)])
    worth = []
    for start, end in zip(ends[:-1], ends[1:], strict=True):
        values = found.values[start:end][kept[start:end]]
        values = values[feasible_front(values, np.zeros((len(values), 0)))]
        one = {"least": float(values[:, 0].min())} if values.shape[1] == 1 and len(values) else {}
        worth.append(
            {"points": int(end - start), "front": len(values), "share": hypervolume(values, found.values[0]), **one}
        )
    return worth


def keeping(study: Study, found: Evaluation) -> np.ndarray:
    """Return which candidates (n,) keep all limits, a constraint within the slack that the race of the searches gives."""
    allowed = np.zeros(found.violations.shape[1])
    allowed[: len(study.constraints)] = [SLACK * entry.most for entry in study.constraints]
    return np.all(found.violations <= allowed, axis=1)


def markdown(runs: list[Run]) -> str:
    """Return the runs as a table."""
    lines = [
        "| study | variant | processor time [s] | flights | points, of them on the front | share held out |",
        "|---|---|---:|---:|---:|---:|",
    ]
    for entry in runs:
        flights = "" if entry["flights"] is None else f"{entry['flights']:,}"
        lines.append(f"| {entry['study']} | {entry['variant']} | {entry['processor_seconds']:.0f} | {flights} | | |")
        for label, worth in entry["fronts"].items():
            told = f"{worth['points']}, {worth['front']} | {worth['share']:.3f} |"
            if label:
                lines.append(f"| | {label} | | | {told}")
            else:
                lines[-1] = lines[-1].removesuffix(" | |") + f" {told}"
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
