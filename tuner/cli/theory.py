"""`tuner theory`: every theorem that speaks of a controller's laws, axis by axis, with the measured disturbance rate."""

import json
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from objectives.theory import THEOREMS, Setting, Theorem
from objectives.theory.disturbance_rate import worst_rates
from objectives.theory.guarantee import Guarantee, law_of, loop_of
from plant.cascade import AXES
from plant.closed_loop import Timing
from plant.nominal import nominal
from plant.scenarios import ScenarioSpec
from tuner.cli.fly import prepare
from tuner.cli.tables import Table
from tuner.cli.terminal import Console
from tuner.gains import Controller, read_gains
from tuner.study import load_study
from tuner.study.guarantees import rate_from_observer

Row = dict[str, Any]
# Root seed of the air where no study gives one, as in `tuner fly`.
SEED = 1


def theory_command(gains: Path, study: Path | None, level: float, as_json: bool) -> None:
    """Work the theorems out and print them."""
    controller = read_gains(gains)
    specs, seed = air_of(controller, study)
    timing = Timing(controller.control_period, controller.plant_step)
    rates = worst_rates(specs, controller.airframe.vehicle, timing, seed, level)
    rows = theory_rows(controller, rates)
    names = [spec.name for spec in specs]
    if as_json:
        print(
            json.dumps({"scenarios": names, "level": level, "axes": AXES, "rates": rates, "theorems": rows}, indent=2)
        )
        return
    print_rows(rows, f"measured in {', '.join(names)}: {100.0 * level:g} % quantile over {timing.control_period:g} s")


def air_of(controller: Controller, study: Path | None) -> tuple[tuple[ScenarioSpec, ...], int]:
    """Return the scenarios to measure the disturbance in and their root seed: the study's, or that of `tuner fly`."""
    if study is None:
        sortie = prepare(controller, None, 0, SEED)
        return (sortie.spec,), sortie.root
    asked = load_study(study)
    return tuple(entry.spec for entry in asked.scenarios), asked.seed


def theory_rows(controller: Controller, rates: dict[str, float]) -> list[Row]:
    """Return a row for each axis and each theorem that speaks of its law; holds is None where there is nothing to hold."""
    knowledge = nominal(controller.airframe.vehicle, controller.options, controller.control_period)
    rows = []
    for axis in AXES:
        law = law_of(controller.cascade, axis).name
        for theorem in THEOREMS.values():
            if theorem.speaks_of(law, rate_from_observer(knowledge, axis)):
                rows.append(theory_row(theorem, controller, axis, rates[axis]))
    return rows


def theory_row(theorem: Theorem, controller: Controller, axis: str, rate: float) -> Row:
    """Return what one theorem says of one axis; an infinite bound is null."""
    guarantee = Guarantee(theorem, controller.cascade, {axis: Setting(controller.control_period, rate)})
    value = float(guarantee.values(np.array([controller.gains]))[0, 0])
    loop = loop_of(axis)
    return {
        "axis": axis,
        "law": law_of(controller.cascade, axis).name,
        "theorem": theorem.name,
        "quantity": theorem.quantity,
        "value": value if isfinite(value) else None,
        "unit": theorem.unit_in(loop),
        "disturbance_rate": rate,
        "rate_unit": "m/s^3" if loop == "position" else "rad/s^3",
        "holds": value >= rate if theorem.sense == "least" else None,
        "assumes": theorem.assumes,
        "source": theorem.source,
    }


def print_rows(rows: list[Row], origin: str) -> None:
    """Print the rows as a table, or say that theory has nothing to say."""
    console = Console()
    if not rows:
        console.print(
            "No theorem speaks of these laws; `tuner list theorems` shows which it speaks of.", highlight=False
        )
        return
    table = Table(f"What theory guarantees; disturbance rate {origin}", keys=2)
    for name in ("axis", "theorem", "value", "disturbance rate", "holds"):
        table.add_column(name, justify="right" if name in ("value", "disturbance rate") else "left", no_wrap=True)
    words = {True: "yes", False: "no", None: "a bound"}
    for row in rows:
        value = "unbounded" if row["value"] is None else f"{row['value']:.4g} {row['unit']}"
        rate = f"{row['disturbance_rate']:.4g} {row['rate_unit']}"
        table.add_row(row["axis"], row["theorem"], value, rate, words[row["holds"]])
    console.print(table)
    for name in dict.fromkeys(row["theorem"] for row in rows):
        theorem = THEOREMS[name]
        console.print(f"{name}: {theorem.quantity}. Assumes {theorem.assumes}.", highlight=False)
