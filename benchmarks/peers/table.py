"""What the race gave, as one table: ratios first, then speeds, compile time and memory."""

import csv
from pathlib import Path
from statistics import median
from typing import Any

from benchmarks.measuring import ratio
from benchmarks.peers.race import Runner

RATIOS = (
    ("lanes / C", "lanes", "C", 0.8),
    ("lanes / C, one thread", "lanes, one thread", "C, one thread", 0.8),
    ("lanes / C with shortcuts, one thread", "lanes, one thread", "C with shortcuts, one thread", None),
    ("lanes / JAX float64", "lanes", "JAX float64", 15.0),
    ("lanes, one thread / NumPy", "lanes, one thread", "NumPy", None),
    ("lanes / crazyflow (another model)", "lanes", "crazyflow", None),
    ("lanes / RotorPy (another model)", "lanes", "RotorPy batched", None),
    ("lanes, one thread / python-control", "lanes, one thread", "python-control", None),
    ("lanes, all threads / one thread", "lanes", "lanes, one thread", None),
)
COLUMNS = (
    "contestant",
    "batch",
    "periods",
    "steps_per_s",
    "steps_per_core_s",
    "ready_s",
    "ready_core_s",
    "peak_mb",
    "same_model",
    "note",
)


def speeds(runner: Runner, batch: int, clock: str) -> list[float]:
    """Return plant steps a second of each round; clock: "wall" or "busy" (a second of one core)."""
    return [entry["steps"] / max(entry[clock], 1e-9) for entry in runner.rounds.get(batch, [])]


def ratio_rows(runners: list[Runner], batches: list[int]) -> list[dict[str, Any]]:
    """Return medians over rounds of ratios within a round, by wall time and by processor time."""
    known = {runner.contestant.name: runner for runner in runners}
    rows = []
    for label, above, below, target in RATIOS:
        for batch in batches:
            if above not in known or below not in known:
                continue
            pair = [known[above], known[below]]
            if not all(batch in runner.rounds for runner in pair):
                continue
            flown = min(len(runner.rounds[batch]) for runner in pair)
            by = {
                clock: ratio(*(speeds(runner, batch, clock)[:flown] for runner in pair)) for clock in ("wall", "busy")
            }
            rows.append({"ratio": label, "batch": batch, **by, "target": target})
    return rows


def speed_rows(runners: list[Runner]) -> list[dict[str, Any]]:
    """Return a row for each contestant and batch."""
    rows = []
    for runner in runners:
        for batch, entries in runner.rounds.items():
            own = runner.contestant
            rows.append(
                {
                    "contestant": own.name,
                    "batch": batch,
                    "periods": entries[0]["steps"] // (4 * batch),
                    "steps_per_s": median(speeds(runner, batch, "wall")),
                    "steps_per_core_s": median(speeds(runner, batch, "busy")),
                    "ready_s": entries[0]["ready_wall"],
                    "ready_core_s": entries[0]["ready_busy"],
                    "peak_mb": max(entry["peak_mb"] for entry in entries),
                    "same_model": own.same,
                    "note": own.note,
                }
            )
    return rows


def markdown(document: dict[str, Any]) -> str:
    """Return the table for people."""
    where = document["machine"]
    lines = [
        "# Peers on one course",
        "",
        f"{where['processor']}, {where['cores']} cores, {where['platform']}; load average at the start {where['load']}. "
        f"`{where['command']}`. {document['rounds']} rounds, contestants in turns, medians.",
        "",
        "Ratios of closed-loop plant steps per second, median over rounds of the quotient within a round. *wall* is what a "
        "user waits for; *core* is per second of processor time, which other people's work on the machine does not touch.",
        "",
        "| ratio | batch | wall | core | target |",
        "|---|---:|---:|---:|---:|",
    ]
    for row in document["ratios"]:
        target = "" if row["target"] is None else f">= {row['target']:g}"
        lines.append(f"| {row['ratio']} | {row['batch']} | {row['wall']:.3g} | {row['busy']:.3g} | {target} |")
    lines += [
        "",
        "| contestant | batch | periods flown | Msteps/s | Msteps/s and core | ready [s] | ready [core s] | peak memory [MB] |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for row in document["speeds"]:
        lines.append(
            f"| {row['contestant']} | {row['batch']} | {row['periods']} | {row['steps_per_s'] / 1e6:.3g} "
            f"| {row['steps_per_core_s'] / 1e6:.3g} | {row['ready_s']:.1f} | {row['ready_core_s']:.1f} | {row['peak_mb']:.0f} |"
        )
    lines += ["", *(f"- {name}: {note}" for name, note in document["notes"].items())]
    lines += ["", *(f"- left out, {name}: {why}" for name, why in document["left_out"].items())]
    return "\n".join(lines).rstrip() + "\n"


def write_csv(file: Path, rows: list[dict[str, Any]]) -> None:
    """Write the speeds for spreadsheets."""
    with file.open("w", newline="", encoding="utf-8") as stream:
        writer: Any = csv.DictWriter(stream, COLUMNS)
        writer.writeheader()
        writer.writerows(rows)
