"""Stepwise approach from the gains of a vehicle to tuned ones."""

from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees, isclose
from pathlib import Path
from shutil import rmtree
from typing import TYPE_CHECKING

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.margins.trim import Trim
from objectives.metrics import parse
from objectives.problem import FlightBatch, Objective, Problem
from objectives.risk import Risk
from plant.errors import InputError
from plant.output_files import make_folders
from plant.quadrotor.gains import gain_addresses
from plant.quadrotor.scenarios import HELD_OUT
from plant.ties import first_largest
from plant.vectors import Vec3
from tuner.analysis.margins.document import margins_document
from tuner.analysis.margins.readings import Subject, subject_of
from tuner.api.exporting import Options, export
from tuner.api.flight_setup import FlightSetup
from tuner.api.frames import Documented, frame, shown
from tuner.api.gains import Gains, GainsLike, QuadrotorGains, gains_of, quadrotor_gains
from tuner.api.studies import StudyLike
from tuner.documents.parts import LawNames
from tuner.extensions.first_flights.approach import (
    factors_between,
    falls_short,
    rows_between,
    steps_between,
    steps_of_size,
)
from tuner.extensions.first_flights.approach_document import (
    APPROACH_FORMAT,
    APPROACH_VERSION,
    ApproachDocument,
    Expected,
    StepOfApproach,
)
from tuner.gains import Controller
from tuner.search.watcher import Watcher, compilation, default_watcher
from tuner.store.folder import Folder
from tuner.text.sentences import value_text

if TYPE_CHECKING:
    import pandas as pd

METRICS = ("rms.position", "rms.attitude", "travel", "saturation")
"""Metrics that a log shows of a flight, predicted for every step."""
FAILURE = "failure"
SEED = 1
# Flights of the check that an export makes of every step's rounding.
CHECKED = 16


@dataclass(frozen=True)
class Approach(Documented):
    """The way to tuned gains.

    Attributes:
        document: Output of `tuner approach --json`.
        gains: The gains of every step, from what flies now to the tuned ones.
        folder: Folder of steps and exports, None if none was written.

    """

    document: ApproachDocument
    gains: tuple[Gains, ...]
    folder: Path | None = None

    @property
    def passed(self) -> bool:
        """True if every step is stable with sufficient margins and no loss."""
        return self.document.passed

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each step: share of the way, and the gains by address."""
        return frame([{"share": step.share, **step.gains} for step in self.document.steps], "share")

    def _repr_html_(self) -> str:
        verdict = (
            "Every step keeps its margins." if self.passed else "A margin falls short, or flights are lost, on the way."
        )
        return shown(f"{len(self.gains) - 1} steps to the tuned gains", [verdict], self.table)


def approach(
    present: GainsLike,
    tuned: GainsLike,
    *,
    steps: int | None = None,
    step: float | None = None,
    study: StudyLike | None = None,
    flights: int = 64,
    to: str | None = None,
    options: Options = (),
    previous: str | Path | None = None,
    out: str | Path | None = None,
    watcher: Watcher | None = None,
) -> Approach:
    """Plan the first flights with tuned gains: steps from what flies now, each checked.

    Args:
        present: Present gains of the vehicle: gains, or a gains.json, as `import_gains` gives them.
        tuned: The tuned gains, of the same laws at the same control period.
        steps: How many; by default few enough that no gain changes by more than half in one, at most 8.
        step: Largest change of a gain in a step as a share of itself, in place of steps; PX4 advises 0.2 to 0.3.
        study: Study whose first scenario the steps fly; by default one metre steps in a fresh breeze.
        flights: Flights of every step.
        to: Target that every step is exported to.
        options: Options of the target.
        previous: Parameter file of what the vehicle flies now, for the rollback of every export.
        out: New folder for approach.json, the gains of every step and their exports.
        watcher: Callbacks that hear of compilation.

    Returns:
        The steps with their margins, what their flights measure, and whether any margin falls short on the way.

    Raises:
        InputError: The gains are of different laws, or there is nothing to approach.
        StoreError: The folder holds something already, or cannot be written.

    Examples:
        >>> found = tuner.approach(gains, results.gains(), steps=2, flights=4)
        >>> found.table.index.tolist()
        [0.0, 0.5, 1.0]

    """
    if to is not None and out is None:
        raise InputError("give a folder for the exports too", key="--out")
    before, after = (quadrotor_gains(each) for each in (present, tuned))
    _check_alike(before.controller, after.controller)
    first, last = (np.array(each.controller.gains) for each in (before, after))
    if steps is not None and step is not None:
        raise InputError("say how many steps, or how large: give --steps or --step")
    usual = steps_between(first, last) if step is None else steps_of_size(first, last, step)
    rows = rows_between(first, last, usual if steps is None else steps)
    between = [gains_of(replace(after.controller, gains=tuple(row.tolist())), {}) for row in rows[1:-1]]
    flight_setup = after.flight_setup(study, 0, SEED)
    folder = None if out is None else Folder.create(Path(out), inside="", empty=True)
    with folder or nullcontext():
        document = _document(before, after, flight_setup, rows, flights, watcher or default_watcher())
        made = Approach(document, (before, *between, after), None if folder is None else folder.path)
        if folder is not None:
            _write(folder, made, to, options, previous)
    return made


def _document(
    before: QuadrotorGains,
    after: QuadrotorGains,
    flight_setup: FlightSetup,
    rows: np.ndarray,
    flights: int,
    watcher: Watcher,
) -> ApproachDocument:
    flown = _flown(flight_setup, rows, flights, watcher)
    subjects = _subjects(after.controller, rows)
    steps_made = [_step(rows, k, subjects, flown[k]) for k in range(len(rows))]
    return ApproachDocument(
        format=APPROACH_FORMAT,
        version=APPROACH_VERSION,
        airframe=after.airframe,
        laws=LawNames(position=after.laws["position"], attitude=after.laws["attitude"]),
        scenario=flight_setup.spec.name,
        flights=flights,
        steps=steps_made,
        notes=option_notes(before.controller, after.controller),
        passed=all(step.stable and not step.short and not step.lost for step in steps_made),
    )


def _check_alike(before: Controller, after: Controller) -> None:
    names = [[each.cascade.position.name, each.cascade.attitude.name] for each in (before, after)]
    if names[0] != names[1]:
        raise InputError(
            f"what flies now is {' / '.join(names[0])}, the tuned gains are of {' / '.join(names[1])}; steps lead between "
            "gains of the same laws: import what the vehicle flies with `tuner import`"
        )
    if before.control_period != after.control_period:
        raise InputError(
            f"what flies now has a control period of {before.control_period:g} s, the tuned gains of {after.control_period:g} s; "
            "give both the same"
        )
    if before.gains == after.gains:
        raise InputError("both are the same gains; there is nothing to approach")


def option_notes(before: Controller, after: Controller) -> list[str]:
    """Return a sentence for each difference besides gains."""
    pairs: list[tuple[str, object, object]] = [
        ("tilt_limit_deg", degrees(before.options.tilt_limit), degrees(after.options.tilt_limit)),
        *[
            (name, getattr(before.options, name), getattr(after.options, name))
            for name in before.options.__dataclass_fields__
            if name != "tilt_limit"
        ],
    ]
    return [
        f"controller.{name} is {value_text(now)} in what flies now and {value_text(then)} in the tuned gains, which every step "
        "is judged with."
        for name, now, then in pairs
        if now != then and not (isinstance(now, float) and isinstance(then, float) and isclose(now, then, rel_tol=1e-3))
    ]


def _subjects(controller: Controller, rows: np.ndarray) -> list[Subject]:
    """Return the margins of every gains row on a controller's airframe.

    All are evaluated by one model.
    """
    subject = subject_of(controller, Trim(0.0, Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 0.0), True))
    return [
        replace(
            subject,
            controller=replace(controller, gains=tuple(row.tolist())),
            margins=subject.model.evaluate(row[None]),
        )
        for row in rows
    ]


@dataclass(frozen=True)
class StepFlights:
    """Metrics of a step's flights, and the number of lost ones."""

    expected: list[Expected]
    lost: int


def _flown(flight_setup: FlightSetup, rows: np.ndarray, flights: int, watcher: Watcher) -> list[StepFlights]:
    """Return the metrics of every gains row, in the same air."""
    objectives = tuple(Objective(parse(name), Risk("mean")) for name in (*METRICS, FAILURE))
    problem = Problem(
        flight_setup.system, DecisionSpace((), (), tuple(rows[0].tolist())), objectives, (), flight_setup.root
    )
    if not problem.flyer.cached:
        with compilation(watcher):
            problem.warm_up(rows[0], flight_setup.spec)
    scores = problem.evaluate_gains(rows, (FlightBatch(flight_setup.spec, HELD_OUT, flights),)).scores
    lost = scores[:, -1] > 0.0
    return [
        StepFlights(
            [_expected(objective, values[~gone]) for objective, values in zip(objectives[:-1], measured, strict=False)],
            int(gone.sum()),
        )
        for measured, gone in zip(scores, lost, strict=True)
    ]


def _expected(objective: Objective, values: np.ndarray) -> Expected:
    """Return the median and 90 % of the values of completed flights; nothing without any."""
    low, median, high = (float(end) for end in np.quantile(values, (0.05, 0.5, 0.95))) if len(values) else [None] * 3
    return Expected(metric=objective.metric.text, unit=objective.metric.unit, median=median, low=low, high=high)


def _step(rows: np.ndarray, k: int, subjects: list[Subject], flown: StepFlights) -> StepOfApproach:
    subject = subjects[k]
    addresses = [gain.address for gain in gain_addresses(subject.controller.cascade)]
    factors = factors_between(rows[max(k - 1, 0)], rows[k])
    most = first_largest(factors)
    channels = margins_document(subject, []).channels
    return StepOfApproach(
        share=k / (len(rows) - 1),
        gains=dict(zip(addresses, rows[k].tolist(), strict=True)),
        gain=addresses[most] if factors[most] > 1.0 else None,
        factor=float(factors[most]),
        stable=all(channel.stable for channel in channels),
        channels=channels,
        short=falls_short(subject, subjects[0], subjects[-1]),
        expected=flown.expected,
        lost=flown.lost,
    )


def _write(folder: Folder, made: Approach, to: str | None, options: Options, previous: str | Path | None) -> None:
    """Write the gains and exports of every step, and the plan.

    The exports are for a target, if one is given. Nothing stays where a step cannot be exported.
    """
    homes = [folder.path / f"step{k}" for k in range(len(made.gains))]
    try:
        for home, gains in zip(homes, made.gains, strict=True):
            make_folders(home)
            gains.write(home / "gains.json")
            if to is not None:
                export(gains, to, home / to, options=options, previous=previous, flights=CHECKED)
    except InputError as error:
        number = sum(home.exists() for home in homes) - 1
        for home in homes:
            rmtree(home, ignore_errors=True)
        remedy = "" if previous else "; with --previous FILE what the vehicle holds already may stay as it is"
        raise InputError(
            f"step {number} of {len(homes) - 1}: {error.message}{remedy}", file=error.file, key=error.key
        ) from error
    folder.write_json("approach.json", made.document)
