"""Reproduce a recorded run on this machine and compare bits.

The study is the same. Replayed from the recorded flights, the search must ask for the recorded candidates and value
them alike; flown again, the candidates must give the recorded meters; judged again, the finalists must give the
recorded front, gains and summary. All other files must be those that manifest.json lists; for a folder of another kind
that is all.

Margins rest on eigenvalues, whose last digits change with the way to find them: within CLOSE they count as the same, and the
verdict tells how far they moved. All other numbers are compared to the bit.
"""

import csv
import json
from dataclasses import asdict, dataclass
from math import floor, log10
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from objectives.memory import model_key
from objectives.problem import Problem
from plant.errors import StoreError
from plant.input_files import parse_json, read_input_text
from plant.seeds import generator
from plant.texts import PlainTable
from tuner.documents.opening import kind_in
from tuner.documents.summary import Summary, gains_name
from tuner.documents.tables import read_frame
from tuner.engines.registry import recorded_engine
from tuner.experiments.again.resume import recorded_study
from tuner.experiments.tuning.conclusion import conclude
from tuner.experiments.tuning.flight_growth import grown_study
from tuner.experiments.tuning.gains_of_run import gains_document
from tuner.experiments.tuning.outcome import Outcome
from tuner.experiments.tuning.problem import first_batches, problem_of, warm_up
from tuner.experiments.tuning.search import flight_store, replayed
from tuner.experiments.tuning.summary import summary_document
from tuner.experiments.tuning.tables import front_table, generation_table
from tuner.gains.hashing import same_result
from tuner.search.convergence import StoppingRule
from tuner.search.loop import Generation, archive, point_name
from tuner.search.watcher import CHECKING, Watcher
from tuner.store.advice import CONTEST, FLOWN_AGAIN, TRIALS, TUNING, kind_of
from tuner.store.columns import Columns, csv_text
from tuner.store.environment import Environment, environment
from tuner.store.flights import RESULTS, FlightStore
from tuner.store.manifest import NONE_YET, Manifest, first_damage, read_manifest
from tuner.store.start import read_start
from tuner.store.tables import table_files
from tuner.study.study import TuningStudy
from tuner.text.markup import element
from tuner.text.toml_text import tables_in

# Candidates flown again at a time.
BATCH = 64
# How far margins may be from those recorded, in parts of themselves, or of 1 where they are smaller: of 286 of a run flown before
# they had eigenvalues of their own, two moved by 2e-8 and 5e-8, the others by 3e-12 at most.
CLOSE = 1e-6
# What summary.json holds that rests on them; and of the time a run took.
ON_MARGINS = ("conflict", "obstacles")
TIMES = ("wall_seconds", "search_seconds")
# What summary.json gets after the run has ended, from flights of its own.
ADDED = {"opinion"}


@dataclass(frozen=True)
class Verdict:
    """The result of a verification.

    Attributes:
        candidates: Number of candidates replayed.
        flown: Number of these flown again.
        flights: Number of flights made for it.
        finished: Whether there is a front.
        difference: The first difference, or None.
        kind: Kind of the run.
        files: Number of files that are as written, None where there is no manifest.
        sources_changed: Whether the run was flown by other sources of the model than those at hand.
        margins_moved: Largest distance of a margin from its record, relative to it, or to 1 where it is smaller.
    """

    candidates: int
    flown: int
    flights: int
    finished: bool
    difference: str | None
    elsewhere: str
    kind: str = TUNING
    files: int | None = None
    sources_changed: bool = False
    margins_moved: float = 0.0

    @property
    def same(self) -> bool:
        """Whether nothing compared differs, the last digits of margins aside."""
        return self.difference is None

    @property
    def identical(self) -> bool:
        """Whether every bit that was looked at is the same."""
        return self.same and not self.margins_moved

    def _repr_html_(self) -> str:
        return element("div", self.words)

    @property
    def words(self) -> str:
        """The verdict as a sentence."""
        if self.difference is not None:
            return f"Different: {self.difference}{self.elsewhere}"
        if self.kind not in FLOWN_AGAIN:
            return self._words_of_files()
        front = "front, gains and summary" if self.finished else "the run is not finished, so there is no front yet"
        files = ""
        if self.finished:
            files = (
                f" Of the folder: {NONE_YET}."
                if self.files is None
                else f" All {self.files} files are what was written."
            )
        head, bits = "Identical", "every bit is the same"
        if not self.identical:
            head = "The same but for the last digits of margins"
            bits = f"margins agree to {floor(-log10(self.margins_moved))} digits, all else to the bit"
        sources = " The sources of the model are not those of the run." if self.sources_changed else ""
        return (
            f"{head}: {self.candidates:,} candidates replayed, {self.flown:,} of them flown again in {self.flights:,} "
            f"flights; {front}; {bits}.{sources}{files}"
        )

    def _words_of_files(self) -> str:
        """The verdict on a folder that is not flown again."""
        if self.files is None:
            return "Not finished: the folder was not written to its end, so there is nothing to compare yet."
        if self.kind == TRIALS:
            return f"Intact: all {self.files} files are what was written. Trials of another program are not made again."
        instead = "; `tuner verify` flies the runs in its contenders/ again" if self.kind == CONTEST else ""
        return f"Intact: all {self.files} files are what was written. A {self.kind} is not flown again{instead}."

    @property
    def json(self) -> str:
        """The verdict as JSON."""
        return json.dumps(self.as_dict(), indent=2)

    def as_dict(self) -> PlainTable:
        """Return the verdict for a program."""
        return {"identical": self.identical, **asdict(self), "words": self.words}


class MismatchError(Exception):
    """The first difference, in words."""


@dataclass
class MarginDeviation:
    """Largest deviation of margins from those recorded so far: `most`, see `Verdict.margins_moved`."""

    most: float = 0.0

    def near(self, stored: np.ndarray, current: np.ndarray) -> np.ndarray:
        """Return a mask of the numbers close to those recorded; update `most`."""
        with np.errstate(invalid="ignore"):
            distance = np.abs(current - stored) / np.maximum(np.abs(stored), 1.0)
        near = distance <= CLOSE
        self.most = max(self.most, float(distance[near].max(initial=0.0)))
        return near


def verify(path: Path, sample: int | None, threads: int | None, watcher: Watcher) -> Verdict:
    """Compare a results folder with what comes out now; sample: fly only so many candidates again, drawn at random."""
    manifest = read_manifest(path)
    if manifest is not None and kind_of(path) not in FLOWN_AGAIN:
        return verify_files(path, manifest)
    study, record = recorded_study(path)
    store = flight_store(study, None, (path,))
    engine = recorded_engine(path, study.system, study.seed)
    fresh = problem_of(study, threads, None, engine, record.model)
    generations: list[Generation] = []
    flown, deviation = np.zeros(0, dtype=int), MarginDeviation()
    finished = (path / "front.csv").exists() if manifest is None else manifest.complete
    try:
        if store.damaged:
            raise MismatchError(f"{store.damaged[0]} is damaged")
        problem = problem_of(study, threads, store, engine, record.model)
        generations = replay(path, study, problem, finished, deviation)
        flown = chosen(generations, sample, study.seed)
        warm_up(fresh, study, watcher)
        refly(study, fresh, generations, flown, store, watcher)
        if finished:
            compare_front(path, study, problem if sample else fresh, generations, watcher, deviation)
        damage = first_damage(path)
        difference = None if damage is None else str(damage)
    except (MismatchError, StoreError) as found:
        difference = str(found)
    candidates = sum(len(entry.points) for entry in generations)
    changed = record.model != model_key()
    files = len(manifest.files) if manifest is not None and manifest.complete else None
    return Verdict(
        candidates,
        len(flown),
        fresh.flights_made,
        finished,
        difference,
        elsewhere(path, changed),
        TUNING,
        files,
        changed,
        deviation.most,
    )


def verify_files(path: Path, manifest: Manifest) -> Verdict:
    """Compare a folder that is not flown again with its manifest."""
    damage = first_damage(path)
    difference = None if damage is None else str(damage)
    files = len(manifest.files) if manifest.complete else None
    return Verdict(0, 0, 0, manifest.complete, difference, "", kind_of(path) or named(path), files)


def named(path: Path) -> str:
    """Return the kind of document in an unrecorded folder, or "folder"."""
    kind_read = kind_in(path)
    return "folder" if kind_read is None else kind_read.kind


def replay(
    path: Path, study: TuningStudy, problem: Problem, finished: bool, deviation: MarginDeviation
) -> list[Generation]:
    """Replay the search and compare every recorded generation; finished: there must be all of them."""
    files = table_files(path / "generations")
    most = study.search.generations
    if finished and len(files) != most and not study.search.budget.converges:
        raise MismatchError(f"{len(files)} generations are recorded, the study has {most}")
    done: list[Generation] = []
    for done in replayed(path, study, problem, study.search.budget if finished else StoppingRule(len(files))):
        if len(done) > len(files):
            raise MismatchError(f"{len(files)} generations are recorded, the search has more")
    for record, file in zip(done, files, strict=False):
        try:
            stored = read_frame(file)
        except StoreError as error:
            raise MismatchError(f"{file} cannot be read ({error.__context__})") from None
        compare_tables(
            f"{file.parent.name}/{file.name}",
            stored,
            generation_table(study, done[: record.number + 1], record),
            margin_columns(study),
            deviation,
        )
    if len(done) != len(files):
        raise MismatchError(f"{len(files)} generations are recorded, and the search ends after {len(done)}")
    return done


def margin_columns(study: TuningStudy) -> set[str]:
    """Return the names of the columns whose numbers are known without flying."""
    return {f"{kind}:{entry.label}" for entry in study.requirements for kind in ("requirement", "violation")}


def compare_tables(name: str, stored: Any, current: Columns, margins: set[str], deviation: MarginDeviation) -> None:
    """Raise the first difference of a pandas table from one made now; margins: columns that need only be close."""
    if list(stored.columns) != list(current) or any(len(values) != len(stored) for values in current.values()):
        raise MismatchError(f"{name} has other columns or rows")
    for column, b in current.items():
        a = stored[column].to_numpy()
        same = (a == b) | ((a != a) & (b != b))
        if column in margins:
            same[~same] = deviation.near(a[~same], b[~same])
        wrong = np.flatnonzero(~same)
        if len(wrong):
            row = int(wrong[0])
            raise MismatchError(f"{name}, row {row}, {column}: recorded {a[row]!r}, now {b[row]!r}")


def chosen(generations: list[Generation], sample: int | None, root: int) -> np.ndarray:
    """Return the candidates to fly again: all that were flown, or a sample of them."""
    flown = np.flatnonzero(archive(generations).flown) if generations else np.zeros(0, dtype=int)
    if sample is None or sample >= len(flown):
        return flown
    return np.sort(generator(root, "verify/sample", 0).choice(flown, sample, replace=False))


def refly(
    study: TuningStudy,
    fresh: Problem,
    generations: list[Generation],
    flown: np.ndarray,
    store: FlightStore,
    watcher: Watcher,
) -> None:
    """Fly candidates again on the search's scenarios; raise the first meter that differs from its record."""
    points = archive(generations).points if generations else np.zeros((0, len(study.space.variables)))
    made = np.concatenate([entry.evaluation.flights_each for entry in generations]) if generations else np.zeros(0)
    flights = first_batches(grown_study(study, generations) if generations else study)
    watcher.on_stage(CHECKING, len(flown) * sum(batch.count for batch in flights))
    for start in range(0, len(flown), BATCH):
        part = flown[start : start + BATCH]
        rows = study.space.gains(points[part])
        missing = made[part].astype(int)
        for batch in flights:
            for first, last in fresh.chunks(batch):
                current = fresh.results(rows, batch, first, last, watcher.on_flights_done)
                for k, candidate in enumerate(part):
                    # A race may have ended before all flights of a candidate were made.
                    stored = store.load_prefix(fresh.key(batch), rows[k], first, last)
                    compare_flights(
                        point_name(int(candidate)), batch.spec.name, first, stored, current[k][: len(stored)]
                    )
                    missing[k] -= len(stored)
        if missing.any():
            candidate = part[np.flatnonzero(missing)[0]]
            raise MismatchError(f"not every flight of {point_name(int(candidate))} is recorded")


def compare_flights(point: str, scenario: str, first: int, stored: np.ndarray, current: np.ndarray) -> None:
    """Raise the first result that differs."""
    wrong = np.argwhere(stored != current)
    if len(wrong):
        flight, row = (int(entry) for entry in wrong[0])
        raise MismatchError(
            f'{point}, scenario "{scenario}", flight {first + flight}, {RESULTS[row]}: recorded '
            f"{float(stored[flight, row])!r}, now {float(current[flight, row])!r}"
        )


def compare_front(
    path: Path,
    study: TuningStudy,
    problem: Problem,
    generations: list[Generation],
    watcher: Watcher,
    deviation: MarginDeviation,
) -> None:
    """Judge the finalists again and compare front.csv, gains.json and summary.json."""
    kind_read = read_start(path, len(study.space.variables))
    assert kind_read is not None, "the replay has read it"
    outcome: Outcome = conclude(problem, study, generations, watcher, perf_counter(), kind_read[1])
    name = gains_name(outcome.feasible)
    try:
        stored = read_input_text(path / "front.csv")
        gains = parse_json(read_input_text(path / name))
        recorded = Summary.parse(read_input_text(path / "summary.json"))
    except (OSError, ValueError) as error:
        raise MismatchError(f"front.csv, {name} or summary.json cannot be read ({error})") from None
    compare_csv("front.csv", stored, csv_text(front_table(outcome)), margin_columns(study), deviation)
    summary, made = recorded.model_dump(by_alias=True, exclude_unset=True, exclude=ADDED), summary_document(outcome)
    now = json.loads(json.dumps(gains_document(outcome, made)))
    if not same_result(gains, with_requirements_of(gains, now, deviation)):
        raise MismatchError(f"{name} holds other values")
    compare_documents("summary.json", summary, json.loads(made.text()), deviation)


def compare_documents(
    name: str, stored: Any, current: Any, deviation: MarginDeviation, key: str = "", margin: bool = False
) -> None:
    """Raise the first difference of two JSON documents; how long something took and what is only told since do not count.

    margin: whether numbers need only be close.
    """
    if isinstance(stored, dict) and isinstance(current, dict) and stored.keys() <= current.keys():
        margin |= stored.get("kind") == "requirement"
        for inner in [entry for entry in stored if key or entry not in TIMES]:
            inside = f"{key}.{inner}" if key else inner
            compare_documents(name, stored[inner], current[inner], deviation, inside, margin or inside in ON_MARGINS)
    elif isinstance(stored, list) and isinstance(current, list) and len(stored) == len(current):
        for i, (a, b) in enumerate(zip(stored, current, strict=True)):
            compare_documents(name, a, b, deviation, f"{key}[{i}]", margin)
    elif stored != current and not (margin and near_numbers(stored, current, deviation)):
        raise MismatchError(f"{name}, {key}: recorded {stored!r:.60}, now {current!r:.60}")


def with_requirements_of(stored: Any, current: PlainTable, deviation: MarginDeviation) -> PlainTable:
    """Return a gains document with the requirements of its record.

    The recorded ones must be close; where there are none, the document stays as it is.
    """
    recorded = stored.get("objectives") if isinstance(stored, dict) else None
    rows = tables_in(current["objectives"])
    if not isinstance(recorded, list) or len(recorded) != len(rows):
        return current
    for i, row in enumerate(rows):
        if row["kind"] == "requirement":
            compare_documents("gains.json", recorded[i], row, deviation, f"objectives[{i}]")
            rows[i] = recorded[i]
    return {**current, "objectives": rows}


def near_numbers(stored: Any, current: Any, deviation: MarginDeviation) -> bool:
    """Return True if two values, or texts of them, are close numbers."""
    try:
        return bool(deviation.near(np.array([float(stored)]), np.array([float(current)]))[0])
    except (TypeError, ValueError):
        return False


def compare_csv(name: str, stored: str, current: str, margins: set[str], deviation: MarginDeviation) -> None:
    """Raise the first cell that differs; numbers are written with all their digits, so that equal texts are equal bits.

    margins: columns that need only be close. Columns that are only told since do not count.
    """
    one, other = (list(csv.DictReader(text.splitlines())) for text in (stored, current))
    if len(one) != len(other) or not one[0].keys() <= other[0].keys():
        raise MismatchError(f"{name} has other columns or rows")
    for i, (a, b) in enumerate(zip(one, other, strict=True)):
        for column, x in a.items():
            if x != b[column] and not (column in margins and near_numbers(x, b[column], deviation)):
                raise MismatchError(f"{name}, row {i}, {column}: recorded {x}, now {b[column]}")
    if one == other and stored != current:
        raise MismatchError(f"{name} is written in another way")


def elsewhere(path: Path, sources_changed: bool) -> str:
    """Return the text on changes of machine and version since the record.

    Such changes could explain a difference; the text is empty where there are none.
    """
    try:
        then = Environment.read(path / "environment.json")
    except StoreError:
        return ""
    now = environment(0)
    names = ("gainproof", "numpy", "scipy", "numba", "llvmlite", "pymoo", "cpu", "simd", "target")
    changed = [
        f"{name} {getattr(then, name)} then, {getattr(now, name)} now"
        for name in names
        if getattr(then, name) != getattr(now, name)
    ]
    changed += ["the sources of the model have changed since"] if sources_changed else []
    return f" ({'; '.join(changed)})" if changed else ""
