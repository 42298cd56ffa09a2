"""The story of a results folder, finished or not, as data: what `tuner show` prints; SI units and radians, as in summary.json."""

import csv
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from pydantic import ConfigDict

from objectives.decisions import Variable as Range
from plant.errors import StoreError
from plant.input_files import read_input_text
from tuner.api.frames import Documented, json_text
from tuner.documents.finalists import FINALIST_COLUMNS
from tuner.documents.opening import open_results
from tuner.documents.parts import LawNames, SampledValue
from tuner.documents.resolved import Resolved
from tuner.documents.summary import PickedOn, TableRow
from tuner.documents.tuning import TuningFolder
from tuner.experiments.registry import folder_kind
from tuner.report.words import laws_of
from tuner.store.advice import CONTEST, RECORD, TRIALS, can_be_resumed, mend, whole
from tuner.store.document import DocumentPart, Scale
from tuner.store.inputs import read_record
from tuner.store.manifest import read_manifest, refuse_damage, unfinished

# What is not shown, and is large: flights are told by the digests in their names, whenever they are read.
UNREAD = ("flights/",)


class UnfinishedContest(DocumentPart):
    """A contest in progress: contenders whose tuning has ended, and those whose tuning has begun."""

    kind: str
    finished: Literal[False]
    title: str
    contenders_finished: list[str]
    contenders_begun: list[str]
    commands: list[str]


class UnfinishedRun(DocumentPart):
    """A run of another kind in progress; shares and hypervolume are those of the last generation, null before the first."""

    kind: str
    finished: Literal[False]
    title: str
    generations: int | None
    generations_done: int
    flights: int
    seconds: float
    feasible_share: float | None
    hypervolume: float | None
    commands: list[str]


class AskedPart(DocumentPart):
    """The question of a tuning run, and what the answer took: of an airframe, or of a plant with the law of each channel.

    None of these, nor a time, where another program made the trials.
    """

    airframe: str | None = None
    laws: LawNames | None = None
    plant: str | None = None
    channels: dict[str, str] | None = None
    seed: int
    searched: list[str]
    objectives: list[str]
    algorithm: str
    candidates: int
    flights: int
    wall_seconds: float | None


class ShownPoint(DocumentPart):
    """The point that stands beside the default, and why it was picked."""

    point: str
    rule: str
    why: str


class PlacedGain(DocumentPart):
    """A searched gain with the places of default and tuned value in its range, 0 to 1 on the range's own scale."""

    name: str
    unit: str
    low: float
    high: float
    scale: Scale
    default: float
    tuned: float
    default_place: float
    place: float


class FrontPoint(DocumentPart):
    """The default or a point of the held-out front: objectives with intervals, and the numbers of `FINALIST_COLUMNS`."""

    model_config = ConfigDict(extra="allow")
    point: str
    role: str
    values: dict[str, SampledValue]


class Trust(DocumentPart):
    """Values that the recommended point was picked by, and the end of the search."""

    picked_on: PickedOn | None
    front_size: int
    generations: int
    hypervolume: float
    feasible_share: float


class TuningStory(DocumentPart):
    """A finished tuning run; commands: what to do next."""

    kind: Literal["tuning"]
    finished: Literal[True]
    feasible: bool
    ending: list[str]
    title: str
    asked: AskedPart
    recommended: ShownPoint | None
    nearest: ShownPoint | None
    shown_as: str
    confirmation_flights: int
    table: list[TableRow]
    gains: list[PlacedGain]
    front: list[FrontPoint]
    trust: Trust
    warnings: list[str]
    remarks: list[str]
    commands: list[str]


@dataclass(frozen=True)
class Story(Documented):
    """The story of a folder.

    Attributes:
        folder: The results folder.
        document: The story of a tuning run or of an unfinished one; the main document of other kinds.
        results: A finished tuning run with its tables, else None.
        guarded: Whether a manifest tells damage of the folder.

    """

    folder: Path
    document: Any
    results: TuningFolder | None
    guarded: bool

    @property
    def json(self) -> str:
        """The document as JSON."""
        return json_text(self.document, ascii_only=False)


def story(folder: Path) -> Story:
    """Return the story of a run, finished or not, of a contest, an inference or a comparison; StoreError where it is none."""
    if not folder.is_dir():
        raise StoreError(f"{folder}: there is no such results folder; give a folder that `tuner run` wrote")
    refuse_damage(folder, UNREAD)
    kind, begun, results = folder_kind(folder), unfinished(folder), None
    if begun or kind is None or not (folder / kind.document).exists():
        if not begun:
            refuse_other(folder)
        document: Any = unfinished_story(folder)
    elif kind.name in ("contest", "inference", "comparison"):
        document = open_results(folder).document
    else:
        results = TuningFolder(folder)
        document = tuning_story(folder, results)
    return Story(folder, document, results, read_manifest(folder) is not None)


def refuse_other(folder: Path) -> None:
    """Refuse a complete folder that is none of a run: its numbers stand in one document and need no story."""
    manifest = read_manifest(folder)
    if manifest is not None and manifest.complete and RECORD not in manifest.files:
        documents = [str(folder / name) for name in manifest.files if name.endswith(".json") and "/" not in name]
        raise StoreError(
            f"{folder} is complete, but not the folder of a run; what was found is in {', '.join(documents)}"
        )


def unfinished_story(folder: Path) -> UnfinishedRun | UnfinishedContest:
    """Return how far a run came that has left no summary yet; StoreError where the folder is none of a run."""
    record = read_record(folder)
    title = title_of(folder / record.study)
    commands = [f"tuner resume {whole(folder)}"] if can_be_resumed(folder) else []
    if record.kind == TRIALS:
        commands = [f"tuner ask {folder / 'study.toml'} --out {folder}"]
    if record.kind == CONTEST:
        own = sorted(path for path in folder.glob("contenders/*") if path.is_dir())
        done = [path.name for path in own if (path / "summary.json").exists()]
        return UnfinishedContest(
            kind=record.kind, finished=False, title=title, contenders_finished=done,
            contenders_begun=[path.name for path in own if path.name not in done], commands=commands,
        )  # fmt: skip
    last = last_generation(folder / "history.csv")
    return UnfinishedRun(
        kind=record.kind, finished=False, title=title, generations=record.generations,
        generations_done=int(last.generation) + 1 if last else 0,
        flights=int(last.flights) if last else 0,
        seconds=last.seconds if last else 0.0,
        feasible_share=last.feasible_share if last else None,
        hypervolume=last.hypervolume if last else None,
        commands=commands,
    )  # fmt: skip


def title_of(study: Path) -> str:
    """Return the title of a study; the name of the file where it cannot be read."""
    try:
        return str(tomllib.loads(read_input_text(study))["title"])
    except (OSError, ValueError, KeyError):
        return study.name


class LastGeneration(NamedTuple):
    """Columns of the last row of history.csv."""

    generation: float
    flights: float
    seconds: float
    feasible_share: float
    hypervolume: float


def last_generation(file: Path) -> LastGeneration | None:
    """Return the last row of history.csv, None before the first generation has ended."""
    try:
        rows = list(csv.DictReader(read_input_text(file).splitlines()))
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError) as error:
        raise StoreError(f"{file} cannot be read ({error}); {mend(file.parent, file.name)}") from None
    return LastGeneration(*(float(rows[-1][name]) for name in LastGeneration._fields)) if rows else None


def tuning_story(folder: Path, results: TuningFolder) -> TuningStory:
    """Return the story of a finished tuning run."""
    summary = results.summary
    feasible = summary.recommends
    shown = ShownPoint(point=summary.shown, **summary.pick.content())
    return TuningStory(
        kind="tuning", finished=True, feasible=feasible, ending=summary.ending, title=summary.title, asked=asked(results),
        recommended=shown if feasible else None, nearest=None if feasible else shown, shown_as=summary.shown_as,
        confirmation_flights=summary.held_out, table=summary.table, gains=placed_gains(results), front=front(results),
        trust=trust(results), warnings=summary.warnings, remarks=summary.remarks,
        commands=next_commands(folder, results),
    )  # fmt: skip


def asked(results: TuningFolder) -> AskedPart:
    """Return what was asked and what it took."""
    resolved, summary = results.resolved, results.summary
    return AskedPart(
        **flown(resolved),
        seed=resolved.seed,
        searched=[variable.name for variable in results.variables],
        objectives=[entry.label for entry in results.objectives],
        algorithm=resolved.search.algorithm,
        candidates=len(results.candidates.number),
        flights=summary.flights,
        wall_seconds=summary.wall_seconds,
    )


def flown(resolved: Resolved) -> dict[str, Any]:
    """Return what flew under which laws; nothing where another program made the trials."""
    laws = {loop: law for law, loop in laws_of(resolved)}
    if resolved.airframe is not None:
        return {"airframe": resolved.airframe.name, "laws": LawNames(**laws)}
    return {} if resolved.plant is None else {"plant": resolved.plant.title, "channels": laws}


def placed_gains(results: TuningFolder) -> list[PlacedGain]:
    """Return the searched gains."""
    found = []
    for row in results.summary.variables:
        span = Range(row.name, (), row.low, row.high, row.scale)
        known = row.model_dump(include={"name", "unit", "low", "high", "scale", "default", "tuned"})
        found.append(PlacedGain(**known, default_place=span.unit(row.default), place=span.unit(row.tuned)))
    return found


def front(results: TuningFolder) -> list[FrontPoint]:
    """Return default and held-out front, by the first objective."""
    found = results.front
    rows = []
    for i in np.argsort(found.held_out[:, 0], kind="stable"):
        if not found.roles[i] and not (found.non_dominated[i] and found.feasible[i]):
            continue
        ends = [found.stored[part][i].tolist() for part in ("held_out", "low", "high")]
        labels = [entry.label for entry in results.objectives]
        rows.append(
            FrontPoint(
                point=found.points[i], role=found.roles[i],
                **{entry.name: entry.cell(found.columns, int(i)) for entry in FINALIST_COLUMNS if entry.form != "flag"},
                values={label: SampledValue(*parts) for label, *parts in zip(labels, *ends, strict=True)},
            )
        )  # fmt: skip
    return rows


def trust(results: TuningFolder) -> Trust:
    """Return how the recommended point did in the search and held out, and how the search ended."""
    history, summary = results.history, results.summary
    return Trust(
        picked_on=summary.picked_on, front_size=summary.front_size, generations=len(history.generation),
        hypervolume=float(history.hypervolume[-1]), feasible_share=float(history.feasible_share[-1]),
    )  # fmt: skip


def next_commands(folder: Path, results: TuningFolder) -> list[str]:
    """Return what to do next; gains that break limits are looked at and not flown."""
    gains = folder / results.summary.gains_file
    if results.told:
        return [f"tuner report {folder}"]
    if not results.has_rotors:
        return [f"tuner export {gains} --to c99 --code MODEL.py", f"tuner report {folder}"]
    if not results.feasible:
        return [f"tuner margins {gains}", f"tuner check {folder / 'study.toml'}", f"tuner report {folder}"]
    return [f"tuner fly {gains} --plot fly.png", f"tuner margins {gains}", f"tuner report {folder}"]
