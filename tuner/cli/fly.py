"""`tuner fly`: fly given gains through turbulence, print metrics over the flights and a plot."""

import json
from dataclasses import dataclass
from math import degrees
from pathlib import Path
from typing import Any

import numpy as np

from objectives.decisions import DecisionSpace
from objectives.metrics import METRICS, parse
from objectives.problem import FlightBatch, Objective, Problem, System
from objectives.risk import Risk
from plant.airframes import load
from plant.cascade import close_cascade
from plant.errors import InputError
from plant.gains import default_row
from plant.laws import law as find_law
from plant.nominal import ControlOptions
from plant.scenarios import HELD_OUT, ScenarioSpec, sample_scenarios
from tuner.analysis.default_scenario import LIMITS, SCENARIO, system_of
from tuner.analysis.responses import SIGNALS, UNITS, Responses, fly_responses
from tuner.cli.display import TerminalWatcher, digits
from tuner.cli.tables import Table
from tuner.cli.terminal import Console
from tuner.gains import Controller, read_gains
from tuner.search.watcher import compilation
from tuner.study import load_study

SHOWN_GROUPS = ("position", "attitude")
SPARKS = "▁▂▃▄▅▆▇█"
FAN_FLIGHTS = 64
# Letters of a line that stand beside its blocks: name, range and unit.
BESIDE = 36


@dataclass(frozen=True)
class Sortie:
    """What is flown: a system, its gains row, a scenario and the root seed."""

    system: System
    gains: np.ndarray
    spec: ScenarioSpec
    root: int


def fly_command(
    gains: Path | None, law: str | None, position_law: str, airframe: str | None, study: Path | None, scenario: int,
    seeds: int, seed: int, plot: Path | None, threads: int | None, as_json: bool,
) -> None:  # fmt: skip
    """Fly and print."""
    if (gains is None) == (law is None):
        raise InputError("give either a gains.json or --law NAME, for instance: tuner fly --law hybrid")
    sortie = prepare(controller_of(gains, law, position_law, airframe), study, scenario, seed)
    addresses = shown_addresses(sortie)
    problem = Problem(
        sortie.system, DecisionSpace((), (), tuple(sortie.gains.tolist())),
        tuple(Objective(parse(address), Risk("mean")) for address in addresses), (), sortie.root, threads,
    )  # fmt: skip
    if not problem.flyer.cached and not as_json:
        with TerminalWatcher(Console()) as watcher, compilation(watcher):
            problem.warm_up(sortie.gains, sortie.spec)
    evaluation = problem.evaluate_gains(sortie.gains[None], (FlightBatch(sortie.spec, HELD_OUT, seeds),))
    figures = statistics(problem.objectives, evaluation.scores[0])
    if as_json:
        print(json.dumps({"scenario": sortie.spec.name, "flights": seeds, "metrics": figures}, indent=2))
    else:
        print_table(figures, sortie, seeds)
    if plot is not None or not as_json:
        responses = responses_of(problem, sortie, min(seeds, FAN_FLIGHTS))
        if not as_json:
            print_sparks(responses)
        if plot is not None:
            from tuner.report.responses_figure import write_responses

            write_responses(responses, sortie.spec.name, plot)


def controller_of(gains: Path | None, law: str | None, position_law: str, airframe: str | None) -> Controller:
    """Return the controller to fly: from a file, or a law's defaults."""
    if gains is not None:
        return read_gains(gains, airframe)
    cascade = close_cascade(find_law(position_law), find_law(str(law)))
    row = tuple(default_row(cascade))
    return Controller(load(airframe or "hummingbird"), cascade, ControlOptions(), 0.004, 0.001, row)


def prepare(controller: Controller, study: Path | None, scenario: int, seed: int) -> Sortie:
    """Return what to fly: the study's scenario and limits where a study is given, the usual ones else."""
    spec, limits = SCENARIO, LIMITS
    if study is not None:
        asked = load_study(study)
        if scenario >= len(asked.scenarios):
            raise InputError(
                f"given scenario {scenario}; allowed: 0 to {len(asked.scenarios) - 1}", file=study, key="--scenario"
            )
        spec, limits, seed = asked.scenarios[scenario].spec, asked.system.limits, asked.seed
    return Sortie(system_of(controller, limits), np.array(controller.gains), spec, seed)


def shown_addresses(sortie: Sortie) -> list[str]:
    """Return the metrics that a flight of this scenario can be judged by, position and attitude."""
    track = sortie.spec.track(sortie.system.timing)
    steps = track.start != track.final
    stepping = {"position": steps[:3].any(), "attitude": steps[3:].any()}
    addresses = []
    for metric in METRICS.values():
        if metric.scope == "flight":
            addresses.append(metric.name)
        else:
            addresses += [f"{metric.name}.{g}" for g in SHOWN_GROUPS if stepping[g] or not metric.needs_step]
    return addresses


def statistics(objectives: tuple[Objective, ...], scores: np.ndarray) -> list[dict[str, Any]]:
    """Return mean with a 95 % interval (normal), median, 95 % quantile and worst of each metric (metrics, flights)."""
    n = scores.shape[1]
    rows = []
    for objective, values in zip(objectives, scores, strict=True):
        half = 1.96 * float(values.std(ddof=1)) / n**0.5 if n > 1 else 0.0
        mean = float(values.mean())
        rows.append(
            {
                "metric": objective.metric.text, "unit": objective.metric.unit, "mean": mean, "low": mean - half,
                "high": mean + half, "median": float(np.median(values)), "q95": float(np.quantile(values, 0.95)),
                "worst": float(values.max()),
            }
        )  # fmt: skip
    return rows


def print_table(figures: list[dict[str, Any]], sortie: Sortie, seeds: int) -> None:
    """Print the metrics."""
    laws = f"{sortie.system.cascade.position.name} / {sortie.system.cascade.attitude.name}"
    table = Table(f"{laws}: {sortie.spec.name}, {seeds} flights of {sortie.spec.duration:g} s", keys=2)
    for name in ("metric", "unit", "mean +- 95 %", "median", "95 % of them", "worst"):
        table.add_column(name, justify="left" if name in ("metric", "unit") else "right", no_wrap=True)
    for row in figures:
        scale = row["high"] - row["low"] or row["mean"]
        half = 0.5 * (row["high"] - row["low"])
        table.add_row(
            row["metric"], row["unit"], f"{digits(row['mean'], scale)} +- {digits(half, scale)}",
            digits(row["median"], scale), digits(row["q95"], scale), digits(row["worst"], scale),
        )  # fmt: skip
    Console().print(table)


def responses_of(problem: Problem, sortie: Sortie, count: int) -> Responses:
    """Fly again with a recorder on."""
    system = sortie.system
    inputs = sample_scenarios(sortie.spec, system.vehicle, system.timing, sortie.root, HELD_OUT, range(count))
    return fly_responses(problem.flyer, sortie.gains, system.nominal, inputs, system.timing.control_period)


def print_sparks(responses: Responses) -> None:
    """Print the median response of each axis as a line of blocks, with its range."""
    _, median, _ = responses.fans()
    blocks = min(max(Console().width - BESIDE, 16), 64)
    columns = np.linspace(0, len(median) - 1, blocks).astype(int)
    for i, name in enumerate(SIGNALS[:6]):
        unit, factor = ("deg", degrees(1.0)) if UNITS[i] == "rad" else (UNITS[i], 1.0)
        # The range is that of the whole response, whatever part of it there is room to draw.
        low, high = factor * float(median[:, i].min()), factor * float(median[:, i].max())
        line = median[columns, i] * factor
        level = np.zeros(len(line), dtype=int) if high <= low else ((line - low) / (high - low) * 7.999).astype(int)
        print(f"{name:>6} {''.join(SPARKS[k] for k in level)}  {low:.2f} to {high:.2f} {unit} (median)")
