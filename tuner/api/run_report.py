"""`tuner show`: a results folder, finished or not, as one JSON document in SI units and radians, as in summary.json."""

import csv
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple, Protocol

from pydantic import JsonValue

from plant.errors import StoreError
from plant.input_files import read_input_text
from tuner.api.frames import json_text
from tuner.api.results import AnyResults, TuningResults, open_results
from tuner.documents.finalists import FINALIST_COLUMNS
from tuner.documents.folder import existing
from tuner.documents.parts import ENDS
from tuner.documents.summary import VariableRow
from tuner.documents.tuning import INTERVAL, TuningFolder
from tuner.experiments.registry import experiments, folder_kind
from tuner.extension import load
from tuner.report.words import laws_of
from tuner.store.advice import RECORD, TRIALS, can_be_resumed, repair_hint, run_root
from tuner.store.document import DocumentPart
from tuner.store.inputs import read_record
from tuner.store.manifest import read_manifest, refuse_damage, unfinished

# What is not shown, and is large: flights are told by the digests in their names, whenever they are read.
UNREAD = ("flights/",)


class Progress(Protocol):
    """A run in progress, of any kind: title, and commands that go on with it."""

    title: str
    commands: list[str]

    @property
    def texts(self) -> list[str]:
        """Sentences on its progress."""
        ...


class UnfinishedRun(DocumentPart):
    """A search in progress; shares and hypervolume are those of the last generation, null before the first."""

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

    @property
    def texts(self) -> list[str]:
        """Sentences on its progress."""
        done = (
            f"Not finished: {self.generations_done} of {self.generations or 'its'} generations, {self.flights:,} flights in "
            f"{self.seconds:.0f} s."
        )
        if self.feasible_share is None:
            return [done]
        return [done, f"Feasible {100.0 * self.feasible_share:.0f} %, hypervolume {self.hypervolume:.4f}."]


@dataclass(frozen=True)
class RunReport:
    """State of a results folder: results of a finished run, or progress of another.

    Attributes:
        folder: The results folder.
        results: Results of a finished run, else None.
        progress: Progress of an unfinished run, else None.
        is_guarded: Whether a manifest tells damage of the folder.

    """

    folder: Path
    results: AnyResults | None
    progress: Progress | None
    is_guarded: bool

    @property
    def document(self) -> DocumentPart | Progress | dict[str, JsonValue] | None:
        """Report of a tuning run or of an unfinished one; the main document of other kinds."""
        if isinstance(self.results, TuningResults):
            return tuning_report(self.results)
        return self.progress if self.results is None else self.results.document

    @property
    def json(self) -> str:
        """The document as JSON."""
        return json_text(self.document, ascii_only=False)


def report_run(folder: Path) -> RunReport:
    """Report a run, finished or not, a contest or comparison.

    Raises StoreError where it is none.
    """
    refuse_damage(existing(folder), UNREAD)
    kind, begun = folder_kind(folder), unfinished(folder)
    if begun or kind is None or not (folder / kind.document).exists():
        if not begun:
            refuse_other(folder)
        return RunReport(folder, None, unfinished_report(folder), True)
    return RunReport(folder, open_results(folder), None, read_manifest(folder) is not None)


def refuse_other(folder: Path) -> None:
    """Refuse a complete folder that is none of a run: its numbers stand in one document and need no story."""
    manifest = read_manifest(folder)
    if manifest is not None and manifest.complete and RECORD not in manifest.files:
        documents = [str(folder / name) for name in manifest.files if name.endswith(".json") and "/" not in name]
        raise StoreError(
            f"{folder} is complete, but not the folder of a run; what was found is in {', '.join(documents)}"
        )


def unfinished_report(folder: Path) -> Progress:
    """Return the progress of a run without a summary; StoreError where the folder is none of a run."""
    record = read_record(folder)
    title = title_of(folder / record.study)
    commands = [f"tuner resume {run_root(folder)}"] if can_be_resumed(folder) else []
    if record.kind == TRIALS:
        commands = [f"tuner ask {folder / 'study.toml'} --out {folder}"]
    kind = experiments().get(record.kind)
    if kind is not None and kind.progress:
        return load(kind.progress)(folder, title, commands)
    last = last_generation(folder / "history.csv")
    return UnfinishedRun(
        kind=record.kind,
        finished=False,
        title=title,
        generations=record.generations,
        generations_done=int(last.generation) + 1 if last else 0,
        flights=int(last.flights) if last else 0,
        seconds=last.seconds if last else 0.0,
        feasible_share=last.feasible_share if last else None,
        hypervolume=last.hypervolume if last else None,
        commands=commands,
    )


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
    """Return the last row of history.csv, None before the first generation's end."""
    try:
        rows = list(csv.DictReader(read_input_text(file).splitlines()))
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError) as error:
        raise StoreError(f"{file} cannot be read ({error}); {repair_hint(file.parent, file.name)}") from None
    return LastGeneration(*(float(rows[-1][name]) for name in LastGeneration._fields)) if rows else None


def tuning_report(results: TuningFolder) -> dict[str, JsonValue]:
    """Return a finished tuning run as JSON, in SI units and radians; keys as in summary.json where that has them."""
    summary, history = results.document, results.progress
    point: dict[str, JsonValue] = {"point": summary.shown, **summary.pick.content()}
    return {
        "kind": results.kind,
        "finished": True,
        "feasible": results.feasible,
        "ending": list(summary.ending),
        "title": summary.title,
        "asked": setup(results),
        "recommended": point if results.feasible else None,
        "nearest": None if results.feasible else point,
        "shown_as": results.shown_as,
        "confirmation_flights": summary.held_out,
        "table": [row.content() for row in summary.table],
        "points": [entry.content() for entry in summary.points],
        "gains": [gain_in_range(row) for row in results.variables],
        "front": [front_point(results, i) for i in results.held_out_front.shown_rows],
        "trust": {
            "picked_on": summary.picked_on and summary.picked_on.content(),
            "front_size": summary.front_size,
            "generations": len(history.generation),
            "hypervolume": float(history.hypervolume[-1]),
            "feasible_share": float(history.feasible_share[-1]),
        },
        "warnings": list(summary.warnings),
        "remarks": list(summary.remarks),
        **({} if summary.opinion is None else {"opinion": summary.opinion.content()}),
        "commands": list(next_commands(results)),
    }


def setup(results: TuningFolder) -> dict[str, JsonValue]:
    """Return the question of a tuning run, and what the answer took; neither plant nor time of trials of another program."""
    resolved, summary = results.resolved, results.document
    laws: dict[str, JsonValue] = {loop: law for law, loop in laws_of(resolved)}
    flown: dict[str, JsonValue] = {}
    if resolved.airframe is not None:
        flown = {"airframe": resolved.airframe.name, "laws": laws}
    elif resolved.plant is not None:
        flown = {"plant": resolved.plant.title, "channels": laws}
    return {
        **flown,
        "seed": resolved.seed,
        "searched": [variable.name for variable in results.variables],
        "objectives": [entry.label for entry in results.objectives],
        "algorithm": resolved.search.algorithm,
        "candidates": len(results.evaluated.number),
        "flights": summary.flights,
        "wall_seconds": summary.wall_seconds,
    }


def gain_in_range(row: VariableRow) -> dict[str, JsonValue]:
    """Return a searched gain with the places of default and tuned value.

    The places are 0 to 1 on the range's scale.
    """
    values = row.model_dump(include={"name", "unit", "low", "high", "scale", "default", "tuned"})
    return {**values, "default_place": row.place(row.default), "place": row.place(row.tuned)}


def front_point(results: TuningFolder, row: int) -> dict[str, JsonValue]:
    """Return the default or a point of the held-out front: objectives with intervals, and the `FINALIST_COLUMNS`."""
    front = results.held_out_front
    numbers = {entry.name: entry.cell(front.columns, row) for entry in FINALIST_COLUMNS if entry.form != "flag"}
    values: dict[str, JsonValue] = {
        entry.label: {name: float(front.stored[part][row, i]) for name, part in zip(ENDS, INTERVAL, strict=True)}
        for i, entry in enumerate(results.objectives)
    }
    return {"point": front.points[row], "role": front.roles[row], "values": values, **numbers}


def next_commands(results: TuningFolder) -> list[str]:
    """Return the next commands; gains that break limits are not flown."""
    folder = results.home
    gains, report = folder / results.document.gains_file, f"tuner report {folder}"
    if results.is_external:
        return [report]
    if not results.has_rotors:
        return [f"tuner export {gains} --to c99 --code MODEL.py", report]
    if not results.feasible:
        return [f"tuner margins {gains}", f"tuner check {folder / 'study.toml'}", report]
    return [f"tuner fly {gains} --plot fly.png", f"tuner margins {gains}", report]
