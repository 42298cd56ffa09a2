"""The tables of a results folder: generations, history, front, constraints, margins, spectra; responses are in `fans`.

results/README.md lists the columns. Constraints rest on the same flights and the same resamples as the front. Margins are
those of the loop in hover in still air as it is flown, at the amplitude of its nonlinear terms at which its sensitivity peaks
highest, on the nominal vehicle; where two channels have the same gains and the same dynamics their rows are alike.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from objectives.margins.loop_margins import LoopMargins
from objectives.margins.quantities import QUANTITIES, RECORDED
from objectives.margins.results import Margins
from objectives.margins.steady_state import HOVER
from objectives.metrics.noise import NOISE
from objectives.problem import Evaluation
from objectives.requirements import Requirement
from plant.errors import InputError
from tuner.analysis.spectrum import command_spectrum
from tuner.documents.finalists import FINALIST_COLUMNS
from tuner.documents.states import tightest_margins
from tuner.documents.summary import RequiredRow
from tuner.documents.tuning import DEFAULT
from tuner.experiments.tuning.fans import drawn
from tuner.experiments.tuning.outcome import FlightOutcome, Outcome
from tuner.search.loop import Generation
from tuner.store.columns import Columns, columns_of, stacked
from tuner.study.searched import SearchedStudy


def generation_table(study: SearchedStudy, generations: list[Generation], record: Generation) -> Columns:
    """Return one generation as a table, a row for each candidate."""
    before = sum(len(entry.points) for entry in generations) - len(record.points)
    values = study.space.values(record.points)
    evaluation = record.evaluation
    columns: Columns = {"candidate": before + np.arange(len(record.points))}
    columns |= {f"gain:{v.name}": values[:, i] for i, v in enumerate(study.space.variables)}
    columns |= {f"objective:{o.label}": evaluation.values[:, i] for i, o in enumerate(study.objectives)}
    columns |= {f"violation:{c.objective.label}": evaluation.violations[:, i] for i, c in enumerate(study.constraints)}
    broken = evaluation.violations[:, len(study.constraints) :]
    columns |= {f"violation:{r.label}": broken[:, i] for i, r in enumerate(study.requirements)}
    columns |= requirement_columns(study.requirements, evaluation)
    columns |= {"flown": evaluation.flown}
    columns |= {"failures": evaluation.failures, "feasible": np.all(evaluation.violations <= 0.0, axis=1)}
    return columns


def requirement_columns(requirements: tuple[Requirement, ...], evaluation: Evaluation) -> Columns:
    """Return the values of the requirements as columns in SI units; an infinite value stands as inf."""
    return {
        f"requirement:{entry.label}": entry.in_file(evaluation.requirements[:, i])
        for i, entry in enumerate(requirements)
    }


def history_table(generations: list[Generation]) -> Columns:
    """Return a search's progress as a table, a row for each generation."""
    return {
        "generation": [entry.number for entry in generations],
        "flights": [entry.flights for entry in generations],
        "screened": [entry.screened for entry in generations],
        "flights_saved": [entry.flights_saved for entry in generations],
        "raced": [entry.raced for entry in generations],
        "flights_raced": [entry.flights_raced for entry in generations],
        "seconds": [entry.seconds for entry in generations],
        "screening_seconds": np.cumsum([entry.evaluation.screening_seconds for entry in generations]),
        "flight_seconds": np.cumsum([entry.evaluation.flight_seconds for entry in generations]),
        "feasible_share": [entry.feasible_share for entry in generations],
        "hypervolume": [entry.hypervolume for entry in generations],
    }


INTERVALS = ("low", "high", "gap", "gap_low", "gap_high", "difference", "difference_low", "difference_high")


def front_table(outcome: Outcome) -> Columns:
    """Return the finalists as a table: default first, then the front of the search along its first objective."""
    study, finalists = outcome.study, outcome.finalists
    rows = [0, *[int(candidate) for candidate in outcome.candidates]]
    chosen = "tuned" if outcome.feasible else "nearest"
    roles = ["default"] + [chosen if row == outcome.tuned else "" for row in range(1, len(rows))]
    columns: Columns = {
        "point": outcome.names,
        "candidate": rows,
        "role": roles,
        **{entry.name: getattr(finalists, entry.name) for entry in FINALIST_COLUMNS},
    }
    gains = outcome.finalist_rows
    columns |= {
        f"gain:{v.name}": gains[:, c[0]] for v, c in zip(study.space.variables, study.space.columns, strict=True)
    }
    parts = {"search": finalists.search, "held_out": finalists.evaluation.values}
    parts |= {name: getattr(finalists, name) for name in INTERVALS}
    for i, objective in enumerate(study.objectives):
        columns |= {f"{name}:{objective.label}": values[:, i] for name, values in parts.items()}
    columns |= requirement_columns(study.requirements, finalists.evaluation)
    return columns


COLUMNS = ("point", "label", "value", "low", "high", "difference", "difference_low", "difference_high")


def constraint_table(outcome: Outcome) -> Columns:
    """Return the constrained quantities on held-out scenarios as a table.

    A row for each finalist and constraint. SI units, with intervals; difference: to the default, paired.
    """
    study, flown = outcome.study, outcome.finalists.flown
    rows = []
    for i, constraint in enumerate(study.constraints, start=len(study.objectives)):
        # Of those that flew on because a limit was open, by all their flights.
        numbers = (*outcome.finalists.limits[:, :, i - len(study.objectives)], *flown.difference_to(i, 0))
        label = constraint.objective.label
        rows += [(name, label, *values) for name, *values in zip(outcome.names, *numbers, strict=True)]
    return columns_of([dict(zip(COLUMNS, row, strict=True)) for row in rows])


# Frequencies of a curve: 28 a decade for a quadrotor, which a line through them does not show.
POINTS = 120
WORST_STATES = "worst_states.npz"
"""File of the loops in their worst steady states."""


def margin_table(outcome: FlightOutcome) -> Columns | None:
    """Return the loops' margins as a table; None where no steady flight exists.

    A row for each finalist and channel with a loop. Columns: point, channel, stable, those of `RECORDED` in SI units
    (empty where no crossing limits a margin, or where the loop is not stable), case (amplitude of the curve in words,
    empty for a linear loop), and the lists frequency [rad/s], real and imag of the loop transfer function.
    """
    try:
        model = outcome.study.margin_model()
    except InputError:
        return None
    return columns_of(loop_rows(model, outcome.finalist_rows, outcome.names))


def worst_state_table(outcome: FlightOutcome, limits: Sequence[RequiredRow]) -> Columns | None:
    """Return the loops of two points in their worst steady states.

    These are default and shown gains; None if hover is the worst state of both. The columns are those of `margin_table`, and
    state. The worst state is that of the margin nearest to its limit.

    Args:
        outcome: The run.
        limits: Limits that are known without flights, in shown units.
    """
    rows = list[dict[str, Any]]()
    for role, limit in tightest_margins(limits).items():
        index, state = (0, limit.default_state) if role == DEFAULT else (outcome.tuned, limit.tuned_state)
        if state in (None, HOVER) or (role != DEFAULT and index == 0):
            continue
        model = outcome.study.margin_model(state)
        loops = loop_rows(model, outcome.gains(index)[None], [outcome.names[index]])
        rows += [{"state": state, **loop} for loop in loops]
    return columns_of(rows) if rows else None


def loop_rows(model: LoopMargins, gains: np.ndarray, names: Sequence[str]) -> list[dict[str, Any]]:
    """Return a row for each point and loop: margins and curve, see `margin_table`.

    Args:
        model: Margins of the loops.
        gains: Gains of the points (n, gains).
        names: Names of the points.
    """
    margins = model.evaluate(gains)
    frequency = model.figure_frequencies(margins, POINTS)
    curves = model.curves(gains, np.maximum(margins.sensitivity.case, 0), frequency)
    looped = {channel for block in model.blocks for channel in block}
    return [
        {"point": name, **loop_row(model, margins, row, channel), **curve_row(frequency, curves[row, i])}
        for row, name in enumerate(names)
        for i, channel in enumerate(margins.channels)
        if channel in looped
    ]


def loop_row(model: LoopMargins, margins: Margins, row: int, channel: str) -> dict[str, str | bool | float | None]:
    """Return the margins of one loop of one finalist."""
    i = margins.channels.index(channel)
    stable, case = bool(margins.stable[row, i]), int(margins.sensitivity.case[row, i])
    values = {name: float(QUANTITIES[name].values(margins)[row, i]) for name in RECORDED}
    return {
        "channel": channel,
        "stable": stable,
        **{name: value if stable and np.isfinite(value) else None for name, value in values.items()},
        "case": model.cases[case].label if case >= 0 else "",
    }


def curve_row(frequency: np.ndarray, loop: np.ndarray) -> dict[str, np.ndarray]:
    """Return the curve of one loop (f,) at frequencies (f,) [rad/s]."""
    parts = {"frequency": frequency, "real": np.real(loop), "imag": np.imag(loop)}
    return {name: part.astype(np.float32) for name, part in parts.items()}


# Held-out flights that a spectrum is averaged over, each recorded at every control instant.
SPECTRUM_FLIGHTS = 16
# Control instants of the longest flight that is recorded: all lanes of a block take 130 MB then.
SPECTRUM_INSTANTS = 50_000


def spectrum_table(outcome: FlightOutcome) -> Columns | None:
    """Return the command spectra of default and tuned gains; None without `noise`.

    Commands are those to rotors or inputs. A row for each point, scenario and frequency [Hz]: density [1/sqrt(Hz)].
    Only studies that judge by the metric `noise` ask.
    """
    study = outcome.study
    judged = [*study.objectives, *[entry.objective for entry in study.constraints]]
    if not any(objective.metric.metric is NOISE for objective in judged):
        return None
    parts = []
    for entry in study.scenarios:
        if entry.spec.steps(study.system.timing) > SPECTRUM_INSTANTS:
            continue
        inputs = drawn(outcome, entry.spec, range(min(SPECTRUM_FLIGHTS, entry.held_out)))
        for row in dict.fromkeys((0, outcome.tuned)):
            spectrum = command_spectrum(study.system, outcome.problem.flyer, outcome.gains(row), inputs)
            if spectrum is not None:
                parts.append({"point": outcome.names[row], "scenario": entry.spec.name, **spectrum._asdict()})
    return stacked(parts) if parts else None
