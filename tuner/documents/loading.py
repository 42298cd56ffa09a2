"""From the files of a results folder to `Results`. Numbers are turned into shown units here and nowhere else."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from objectives.scales import DECIBEL
from plant.errors import StoreError
from tuner.documents.ending import gains_file
from tuner.documents.files import Columns, Node, numbers, read_table, read_text, refuse
from tuner.documents.loading_finalists import addresses_of, design_start, read_limited, read_loops, read_sensitivity
from tuner.documents.results import (
    TUNED,
    Candidates,
    Estimate,
    Fan,
    Front,
    History,
    Quantity,
    Required,
    Results,
    Variable,
)
from tuner.text.units import in_degrees

KINDS = ("objective", "constraint", "requirement")
SENSES = ("most", "least")
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
    summary = Node.read(folder / "summary.json")
    names = ("resolved.json", "environment.json", gains_file(summary.value))
    resolved, environment, gains = (Node.read(folder / name) for name in names)
    _check(summary, resolved, gains)
    rows = [(_one_of(row, "kind", KINDS), row) for row in summary["table"].entries()]
    quantities = [_quantity(row, kind == "constraint") for kind, row in rows if kind != "requirement"]
    requirements = [_required(row) for kind, row in rows if kind == "requirement"]
    objectives = [quantity for quantity in quantities if not quantity.constrained]
    if not objectives:
        raise refuse(summary.file, "'table' holds no objective")
    variables = [_variable(row) for row in summary["variables"].entries()]
    front = _front(folder / "front.csv", objectives, variables, requirements)
    fans = _fans(folder / "responses.parquet")
    return Results(
        folder=folder,
        summary=summary.value,
        resolved=resolved.value,
        environment=environment.value,
        gains=gains.value,
        study=read_text(folder / "study.toml"),
        quantities=quantities,
        requirements=requirements,
        variables=variables,
        front=front,
        candidates=_candidates(folder / "generations", objectives, variables),
        history=_history(folder / "history.csv"),
        fans=fans,
        gains_text=read_text(gains.file),
        addresses=addresses_of(resolved.value, [variable.name for variable in variables], gains.value["gains"]),
        limited=read_limited(folder / "constraints.csv"),
        loops=read_loops(folder / "margins.parquet"),
        start=design_start(folder, resolved.value),
        sensitivity=read_sensitivity(folder / "sensitivity.json"),
    )


def _check(summary: Node, resolved: Node, gains: Node) -> None:
    """Touch every key that the report reads from the bare documents, so that a missing one is named here."""
    for key in ("title", "study", "nearest" if summary.get("tuned") is None and summary.get("nearest") else "tuned"):
        summary[key].text()
    for row in Node(summary.get("ending", []), summary.file, "ending").entries():
        row.text()
    for key in ("flights", "wall_seconds", "held_out", "front_size", "hypervolume"):
        summary[key].number()
    for key in ("rule", "why"):
        summary["pick"][key].text()
    for row in summary["air"].entries():
        row["scenario"].text()
    for warning in summary["warnings"].entries():
        warning.text()
    resolved["airframe"]["name"].text()
    resolved["search"]["algorithm"].text()
    for loop in ("position", "attitude"):
        resolved["controller"][loop].text()
    resolved["seed"].number()
    for _, gain in gains["gains"].items():
        gain["value"].number()
        gain["unit"].text()


def _one_of(row: Node, key: str, allowed: tuple[str, ...]) -> str:
    given = row[key].text()
    if given not in allowed:
        raise refuse(row.file, f"'{row.key}.{key}' is '{given}' and neither of {', '.join(allowed)}")
    return given


def _quantity(row: Node, constrained: bool) -> Quantity:
    unit, factor = in_degrees(row["unit"].text())
    scenario = row.get("scenario")
    return Quantity(
        label=row["label"].text(),
        metric=row["metric"].text(),
        definition=row["definition"].text(),
        risk=row["risk"].text(),
        scenario=None if scenario is None else str(scenario),
        unit=unit,
        factor=factor,
        constrained=constrained,
        limit=None if row.get("limit") is None else row["limit"].number() * factor,
        default=_estimate(row["default"], factor),
        tuned=_estimate(row["tuned"], factor),
        difference=_estimate(row["difference"], factor),
        verdict=row["verdict"].text(),
        automatic=str(row.get("automatic") or ""),
    )


def _required(row: Node) -> Required:
    unit, factor = in_degrees(row["unit"].text())
    stored = Required(
        label=row["label"].text(),
        quantity=row["quantity"].text(),
        unit=unit,
        factor=factor,
        limit=row["limit"].number() * factor,
        sense=_one_of(row, "sense", SENSES),
        default=_estimate(row["default"], factor),
        tuned=_estimate(row["tuned"], factor),
        difference=_estimate(row["difference"], factor),
        verdict=row["verdict"].text(),
    )
    return _in_decibel(stored) if row.get("shown_unit") == DECIBEL.unit else stored


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


def _estimate(node: Node, factor: float) -> Estimate:
    return Estimate(
        *[None if node.get(name) is None else node[name].number() * factor for name in ("value", "low", "high")]
    )


def _variable(row: Node) -> Variable:
    return Variable(
        name=row["name"].text(),
        symbol=str(row.get("symbol") or ""),
        meaning=str(row.get("meaning") or ""),
        unit=row["unit"].text(),
        low=row["low"].number(),
        high=row["high"].number(),
        scale=row["scale"].text(),
        default=row["default"].number(),
        tuned=row["tuned"].number(),
        natural_ends=tuple(entry.text() for entry in row["natural_ends"].entries()) if row.get("natural_ends") else (),
    )


def _front(
    file: Path, objectives: list[Quantity], variables: list[Variable], requirements: list[Required]
) -> Front:  # fmt: skip
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
    return Front(
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


def _candidates(folder: Path, objectives: list[Quantity], variables: list[Variable]) -> Candidates:
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
    if not file.exists():
        return []
    table = read_table(file, FAN_KEYS + FAN_NUMBERS, WORST)
    if table.num_rows == 0:
        return []
    encoded = [codes_of(table.column(key), file) for key in FAN_KEYS]
    # Rows of one fan are neighbours in the file, but nothing promises it: sort by group, keeping the order of time.
    group = np.ravel_multi_index([codes for codes, _ in encoded], [len(names) for _, names in encoded])
    order = np.argsort(group, kind="stable")
    starts = np.flatnonzero(np.diff(group[order], prepend=-1))
    wanted = FAN_NUMBERS + [name for name in WORST if name in table.column_names]
    values = numbers(table, wanted, file)
    fans = []
    for rows in np.split(order, starts[1:]):
        point, scenario, signal, unit = (names[int(codes[rows[0]])] for codes, names in encoded)
        shown, factor = in_degrees(unit)
        time, *series = values[rows].T
        flight = int(series.pop()[0]) if len(wanted) > len(FAN_NUMBERS) else None
        fans.append(Fan(point, scenario, signal, shown, time, *[entry * factor for entry in series], flight=flight))
    return fans


def codes_of(column: Any, file: Path) -> tuple[np.ndarray, list[str]]:
    """Return a text column as codes (rows,) into a list of names, which are in order of appearance."""
    try:
        encoded = column.cast(pa.string()).combine_chunks().dictionary_encode()
    except pa.ArrowException as error:
        raise refuse(file, f"a column holds no text ({error})") from None
    if encoded.null_count:
        raise refuse(file, "a name is missing")
    return encoded.indices.to_numpy(), encoded.dictionary.to_pylist()
