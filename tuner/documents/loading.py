"""From the files of a results folder to `Results`. Numbers are turned into shown units here and nowhere else."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from objectives.scales import DECIBEL
from plant.errors import StoreError
from tuner.documents.files import Columns, groups, numbers, read_table
from tuner.documents.loading_finalists import addresses_of, design_start, read_limited, read_loops
from tuner.documents.parts import Estimate, RecommendedGains
from tuner.documents.resolved import Resolved
from tuner.documents.results import (
    TUNED,
    Candidates,
    ComparedQuantity,
    Fan,
    HeldOutFront,
    History,
    Required,
    Results,
    SearchedVariable,
)
from tuner.documents.sensitivity import SensitivityDocument
from tuner.documents.summary import ComparedRow, RequiredRow, Summary, VariableRow
from tuner.store.document import read_text, refuse
from tuner.store.environment import Environment
from tuner.text.units import in_degrees

FAN_KEYS = ["point", "scenario", "signal", "unit"]
FAN_NUMBERS = ["time", "reference", "low", "median", "high"]
# Columns of fans, of the history and of the front that folders of earlier versions lack.
WORST = ["worst", "worst_flight"]
SAVED = ("flights_saved", "flights_raced")
JUDGED = (
    "search",
    "held_out",
    "low",
    "high",
    "gap",
    "gap_low",
    "gap_high",
    "difference",
    "difference_low",
    "difference_high",
)


def load(folder: Path) -> Results:
    """Read a results folder; StoreError names the file that is missing or damaged. Responses may be missing."""
    if not folder.is_dir():
        raise StoreError(f"{folder}: there is no such results folder; give a folder that `tuner run` wrote")
    summary = Summary.read(folder / "summary.json")
    resolved = Resolved.read(folder / "resolved.json")
    environment = Environment.read(folder / "environment.json")
    gains = RecommendedGains.read(folder / summary.gains_file)
    quantities = [_quantity(row) for row in summary.compared]
    requirements = [_required(row) for row in summary.required]
    objectives = [quantity for quantity in quantities if not quantity.constrained]
    variables = [_variable(row) for row in summary.variables]
    analysis = folder / "sensitivity.json"
    return Results(
        folder=folder,
        summary=summary,
        resolved=resolved,
        environment=environment,
        gains=gains,
        study=read_text(folder / "study.toml"),
        quantities=quantities,
        requirements=requirements,
        variables=variables,
        front=_front(folder / "front.csv", objectives, variables, requirements),
        candidates=_candidates(folder / "generations", objectives, variables),
        history=_history(folder / "history.csv"),
        fans=_fans(folder / "responses.parquet"),
        gains_text=read_text(folder / summary.gains_file),
        addresses=addresses_of(resolved, [variable.name for variable in variables], gains),
        limited=read_limited(folder / "constraints.csv"),
        loops=read_loops(folder / "margins.parquet"),
        start=design_start(folder, resolved),
        sensitivity=SensitivityDocument.read(analysis) if analysis.exists() else None,
    )


def _quantity(row: ComparedRow) -> ComparedQuantity:
    unit, factor = in_degrees(row.unit)
    return ComparedQuantity(
        label=row.label,
        metric=row.metric,
        definition=row.definition,
        risk=row.risk,
        scenario=row.scenario,
        unit=unit,
        factor=factor,
        constrained=row.kind == "constraint",
        limit=None if row.limit is None else row.limit * factor,
        default=row.default.times(factor),
        tuned=row.tuned.times(factor),
        difference=row.difference.times(factor),
        verdict=row.verdict,
        automatic=row.automatic,
    )


def _required(row: RequiredRow) -> Required:
    unit, factor = in_degrees(row.unit)
    stored = Required(
        label=row.label,
        quantity=row.quantity,
        unit=unit,
        factor=factor,
        limit=row.limit * factor,
        sense=row.sense,
        default=row.default.times(factor),
        tuned=row.tuned.times(factor),
        difference=row.difference.times(factor),
        verdict=row.verdict,
    )
    return _in_decibel(stored) if row.shown_unit == DECIBEL.unit else stored


def _in_decibel(stored: Required) -> Required:
    """Return a requirement on a factor as one on its level in dB; the difference is that of the levels."""
    default, tuned = (
        None if entry.value is None else float(DECIBEL.shown(entry.value)) for entry in (stored.default, stored.tuned)
    )
    apart = None if default is None or tuned is None else tuned - default
    limit = float(DECIBEL.shown(stored.limit))
    shown = [Estimate(value, None, None) for value in (default, tuned, apart)]
    return replace(
        stored, unit=DECIBEL.unit, limit=limit, default=shown[0], tuned=shown[1], difference=shown[2], decibel=True
    )


def _variable(row: VariableRow) -> SearchedVariable:
    return SearchedVariable(**{**vars(row), "natural_ends": tuple(row.natural_ends)})


def _front(
    file: Path, objectives: list[ComparedQuantity], variables: list[SearchedVariable], requirements: list[Required]
) -> HeldOutFront:  # fmt: skip
    table = Columns.read(file)
    factors = np.array([objective.factor for objective in objectives])
    stored = {
        prefix: np.stack([table.numbers(f"{prefix}:{entry.label}") for entry in objectives], axis=1)
        for prefix in JUDGED
        if prefix in JUDGED[:4] or f"{prefix}:{objectives[0].label}" in table.columns
    }

    def values(prefix: str) -> np.ndarray:
        return stored[prefix] * factors

    known = [table.numbers(name) if (name := f"requirement:{entry.label}") in table.columns else np.full(rows, np.nan)
             for entry in requirements for rows in [len(table.text("point"))]]  # fmt: skip
    gains = [table.numbers(f"gain:{variable.name}") for variable in variables]
    return HeldOutFront(
        points=table.text("point"),
        roles=[TUNED if role == "nearest" else role for role in table.text("role")],
        candidates=table.numbers("candidate"),
        non_dominated=table.flags("non_dominated"),
        feasible=table.flags("feasible"),
        gains=np.stack(gains, axis=1) if gains else np.empty((len(table.text("point")), 0)),
        search=values("search"),
        held_out=values("held_out"),
        low=values("low"),
        high=values("high"),
        stored=stored,
        requirements=np.stack(known, axis=1) if known else np.empty((len(table.text("point")), 0)),
        lost=table.numbers("lost").astype(int)
        if "lost" in table.columns
        else np.zeros(len(table.text("point")), dtype=int),
        probability=table.numbers("probability") if "probability" in table.columns else None,
    )


def _candidates(folder: Path, objectives: list[ComparedQuantity], variables: list[SearchedVariable]) -> Candidates:
    gains = [f"gain:{variable.name}" for variable in variables]
    values = [f"objective:{objective.label}" for objective in objectives]
    files = sorted(folder.glob("*.parquet"))
    if not files:
        raise refuse(folder, "there is no generation in it")
    columns = ["candidate", "feasible", *gains, *values]
    parts = [numbers(read_table(file, columns), columns, file) for file in files]
    rows = np.concatenate(parts, axis=0)
    split = 2 + len(gains)
    factors = np.array([objective.factor for objective in objectives])
    return Candidates(rows[:, 0].astype(int), rows[:, 2:split], rows[:, split:] * factors, rows[:, 1] > 0.5)


def _history(file: Path) -> History:
    table = Columns.read(file)
    names = ("generation", "flights", "seconds", "feasible_share", "hypervolume")
    saved = {name: table.numbers(name) for name in SAVED if name in table.columns}
    return History(*[table.numbers(name) for name in names], **saved)


def _fans(file: Path) -> list[Fan]:
    """Return the fans of every point, scenario and signal, none where the file is missing."""
    fans = []
    for (point, scenario, signal, unit), values in groups(file, FAN_KEYS, FAN_NUMBERS, WORST, by_name=True):
        shown, factor = in_degrees(unit)
        time, *series = values.T
        flight = int(series.pop()[0]) if values.shape[1] > len(FAN_NUMBERS) else None
        fans.append(Fan(point, scenario, signal, shown, time, *[entry * factor for entry in series], flight=flight))
    return fans
