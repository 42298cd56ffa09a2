"""Checks of a file without flights, and judgement by a study's limits."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from plant.errors import InputError
from plant.quadrotor.airframes import load as load_airframe
from plant.quadrotor.airframes.derived import quantities
from plant.texts import PlainValue
from tuner.analysis.judgement import check_batches, judge_gains, judgement_document, row_to_judge
from tuner.api.frames import Documented, frame, shown
from tuner.api.gains import Gains, GainsLike, as_gains
from tuner.api.margins import announce_compilation
from tuner.api.studies import StudyLike, gains_study
from tuner.documents.judgement import JudgementDocument
from tuner.documents.opening import gains_file
from tuner.experiments.planning.preview import Preview, preview
from tuner.experiments.tuning.problem import problem_of, warm_up
from tuner.gains.examining import Examined, examine
from tuner.gains.sections import Row
from tuner.search.watcher import JUDGING, Watcher, default_watcher
from tuner.study.files import study_file
from tuner.study.kinds import kind_of_layers, load_any
from tuner.study.layers import read_layers
from tuner.study.own_code import examine_own, plant_source
from tuner.study.study import Study

if TYPE_CHECKING:
    import pandas as pd


AIRFRAME_KEYS = {"frame", "spin", "mass", "inertia"}
"""Keys that every airframe has at its top and no study."""


@dataclass(frozen=True)
class Checked(Documented):
    """Everything known of a file without flying.

    Attributes:
        kind: Kind of the file: "study", "contest", "trials", "airframe", "gains", "law", "metric", "reference",
            "plant" or "fmu".
        document: Its content: the preview of a study of any kind; plain data of the other kinds.
        hopeless: Whether a study asks for what nothing can reach, a gains file is wrong, or code of your own breaks its contract.
        examined: A gains file as read, None for other files.

    """

    kind: str
    document: Preview | Row
    hopeless: bool = False
    examined: Examined | None = None

    @property
    def problems(self) -> list[InputError]:
        """Everything that is wrong with a gains file."""
        return [] if self.examined is None else self.examined.problems

    @property
    def content(self) -> Row:
        """The document as plain data."""
        return self.document if isinstance(self.document, dict) else self.document.content()

    def _repr_html_(self) -> str:
        lines = [f"{key}: {value}" for key, value in self.content.items() if isinstance(value, str | int | float)]
        return shown(f"Checked: {self.kind}", lines)


def check(
    file: GainsLike, *, changes: Mapping[str, PlainValue] | None = None, watcher: Watcher | None = None
) -> Checked:
    """Check a file of any kind without flying.

    Args:
        file: A study, contest or airframe (TOML), gains or a gains.json, a law, metric, reference or plant of your own
            (Python, which is run), an FMU (which is not), or the name of a shipped study.
        changes: Values that replace those of a study, by dotted key.
        watcher: Callbacks that hear of compilation.

    Returns:
        Its content; of a study trim, margins of the default, and limits that nothing can reach.

    Raises:
        InputError: The file is missing or wrong, or changes are given for another file than a study.

    Examples:
        >>> tuner.check("quickstart").document.vehicle.name
        'hummingbird'

    """
    if isinstance(file, Gains):
        return validate(file)
    path = study_file(Path(file))
    if changes and path.suffix != ".toml":
        raise InputError("values are replaced in studies alone; leave --set out", file=path, key="changes")
    if path.is_dir():
        raise InputError(
            "this is a folder; `tuner show` tells a results folder, `tuner verify` flies it again", file=path
        )
    if path.suffix == ".json":
        return validate(path)
    if path.suffix == ".py":
        return check_own(path)
    source = plant_source(path)
    if source is not None:
        return Checked(path.suffix[1:], source.describe(path))
    layers = read_layers(path)
    keys = set(layers[0].table)
    if kind_of_layers(layers).table is None and AIRFRAME_KEYS & keys and not {"scenario", "objective"} & keys:
        return Checked("airframe", airframe_figures(path))
    subject = load_any(path, changes)
    if subject.kind == Study.kind and any("margin" in layer.table for layer in layers):
        announce_compilation(watcher or default_watcher())
    result = preview(subject)
    return Checked(result.kind, result, result.is_hopeless)


def validate(gains: GainsLike) -> Checked:
    """Check schema, units, ranges and hash of a gains.json.

    Of a plant's gains, check the form of its loops and gains.

    Args:
        gains: The file, the results folder that it lies in, or gains.

    Returns:
        The verdict; `hopeless` where it is not valid, with everything wrong in `problems`.

    Raises:
        InputError: The file is no gains.json at all.

    Examples:
        >>> tuner.validate("mine.json").document["hash"]
        'ok'
    """
    if isinstance(gains, Gains):
        with gains.file() as file:
            return validate(file)
    path = gains_file(Path(gains))
    examined = examine(path)
    state = "missing" if "sha256" not in examined.given else "ok"
    if any(problem.key == "sha256" for problem in examined.problems):
        state = "wrong" if state == "ok" else state
    verdict = {
        "file": str(examined.path),
        "valid": not examined.problems,
        "version": examined.given.get("version"),
        "hash": state,
        "sha256": None if examined.problems else examined.digest,
        "problems": [{"key": problem.key, "message": problem.message} for problem in examined.problems],
    }
    return Checked("gains", verdict, bool(examined.problems), examined)


def check_own(file: Path) -> Checked:
    """Hold code of the user's own against the contract of its kind."""
    examined = examine_own(file)
    verdict = {
        "kind": examined.noun,
        "name": examined.name,
        "file": str(file),
        "digest": examined.digest,
        "breaches": [breach._asdict() for breach in examined.breaches],
    }
    return Checked(examined.noun, verdict, bool(examined.breaches))


def airframe_figures(file: Path) -> Row:
    """Return figures of a vehicle; what is wrong with its file is an error that names the key."""
    airframe = load_airframe(file, allow_unphysical=True)
    numbers = {name: {"value": entry.value, "unit": entry.unit} for name, entry in quantities(airframe.vehicle).items()}
    return {
        "kind": "airframe",
        "name": airframe.name,
        "title": airframe.title,
        "frame": airframe.frame,
        "mass": {"value": airframe.vehicle.mass, "unit": "kg"},
        **numbers,
    }


@dataclass(frozen=True)
class Judgement(Documented):
    """Gains against the limits of a study; document: as `tuner check --requirements --json` prints it."""

    document: JudgementDocument

    @property
    def verdict(self) -> str:
        """Verdict: "pass", "fail" or "not certain"."""
        return str(self.document.verdict)

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each limit and objective: value with its 95 % interval, limit, verdict."""
        return frame(self.document.rows, "label")

    def _repr_html_(self) -> str:
        return shown(f"Verdict: {self.verdict}", (), self.table)


def check_requirements(
    gains: GainsLike,
    study: StudyLike,
    *,
    flights: int | None = None,
    watcher: Watcher | None = None,
    threads: int | None = None,
) -> Judgement:
    """Fly gains and judge them by the hard limits of a study.

    The scenarios are ones that no search has seen.

    Args:
        gains: Gains, a gains.json or a results folder.
        study: A tuning study, of a plant of your own too, a file, or the name of a shipped study.
        flights: Flights of each scenario; by default the study's held_out.
        watcher: Callbacks that hear of progress.
        threads: Threads, by default one for each core.

    Returns:
        A verdict on each limit.

    Raises:
        InputError: The study limits nothing, or is about other laws, other loops or another airframe.

    Examples:
        >>> tuner.check_requirements("results/first/gains.json", study, flights=16).table.index[0]
        'mean(failure)'

    """
    watcher = watcher or default_watcher()
    subject = gains_study(study, "tuner check --requirements")
    with as_gains(gains).file() as file:
        row = row_to_judge(file, subject)
    problem, batches = problem_of(subject, threads, None), check_batches(subject, flights)
    warm_up(problem, subject, watcher)
    watcher.on_stage(JUDGING, sum(batch.count for batch in batches))
    rows = judge_gains(row, subject, problem, batches, watcher.on_flights_done)
    return Judgement(judgement_document(file, subject, rows, batches))
