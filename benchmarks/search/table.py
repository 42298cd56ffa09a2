"""The race as tables: shares of the best known over flights and over processor time, and who is ahead."""

from collections.abc import Iterable
from math import inf, isinf
from statistics import median
from typing import Any, NamedTuple

import numpy as np

from benchmarks.search.contestants import AUTO, BEFORE, CONTESTANTS
from benchmarks.search.problems import FLIGHTS, PROBLEMS
from tuner.search.front import feasible_front, hypervolume

Runs = list[dict[str, Any]]
# Flights and processor seconds at which contestants are compared, and the share of the best known that is enough.
AT_FLIGHTS, AT_SECONDS, ENOUGH = (200, 500, 1000, 3000, 11_000), (3, 10, 30), 0.95
# Flights at which the default is to be ahead.
DECIDING = (500, 1000, 3000)
# Share of flights beyond a mark that a batch may end late.
LATE = 1.05


class Curve(NamedTuple):
    """Shares of the best known that one run reached (n,), with its flights and processor seconds (n,)."""

    seed: int
    shares: list[float]
    flights: list[int]
    seconds: list[float]

    def after(self, flights: float) -> float | None:
        """Return the share after so many flights, of one that ended before that at its end; None where none was judged yet."""
        at = [i for i, count in enumerate(self.flights) if count <= LATE * flights]
        return self.shares[at[-1]] if at else None

    def ended(self, flights: float) -> bool:
        """Return whether the run ended before so many flights."""
        return self.flights[-1] * LATE < flights

    def within(self, seconds: float) -> float | None:
        """Return the share after so many seconds, of one that ended before that at its end; None where none was judged yet."""
        at = [i for i, spent in enumerate(self.seconds) if spent <= seconds]
        return self.shares[at[-1]] if at else None

    def enough(self) -> tuple[int, float] | None:
        """Return the flights and seconds at which it first reached enough of the best known, None where it never did."""
        for share, flights, seconds in zip(self.shares, self.flights, self.seconds, strict=True):
            if share >= ENOUGH:
                return flights, seconds
        return None


def curves(runs: Runs, problem: str) -> dict[str, list[Curve]]:
    """Return the curves of a problem's runs by contestant, in the order of the registry."""
    best = best_known(runs, problem)
    found: dict[str, list[Curve]] = {}
    for name in CONTESTANTS:
        mine = [run for run in runs if run["problem"] == problem and run["contestant"] == name and run["entries"]]
        if mine:
            found[name] = [_curve(run, best[run["seed"]]) for run in sorted(mine, key=lambda run: run["seed"])]
    return found


def best_known(runs: Runs, problem: str) -> dict[int, float]:
    """Return the worth of all fronts of a problem together by seed: a share of the box, or one objective's least value.

    Fronts of all seeds count together where all were judged on the same flights.
    """
    found: dict[int, float] = {}
    judged = [run for run in runs if run["problem"] == problem]
    for seed in sorted({run["seed"] for run in judged}):
        same = PROBLEMS[problem].judge_seed is not None
        mine = [run for run in judged if run["front"] and (same or run["seed"] == seed)]
        if mine:
            front, default = np.concatenate([run["front"] for run in mine]), np.array(mine[0]["default"])
            front = front[feasible_front(front, np.zeros((len(front), 0)))]
            found[seed] = hypervolume(front, default) if len(default) > 1 else float(front.min())
    return found


def _curve(run: dict[str, Any], best: float) -> Curve:
    entries = run["entries"]
    return Curve(
        run["seed"],
        [_share(entry["worth"], best, len(run["default"])) for entry in entries],
        [entry["flights"] for entry in entries],
        [entry["seconds"] for entry in entries],
    )


def _share(worth: float | None, best: float, objectives: int) -> float:
    """Return how near a worth is to the best known: a share of its hypervolume, or the quotient of two small values."""
    if worth is None:
        return 0.0
    return worth / best if objectives > 1 else best / worth


def markdown(runs: Runs) -> str:
    """Return the tables for people."""
    problems = [problem for problem in PROBLEMS if any(run["problem"] == problem for run in runs)]
    parts = [INTRODUCTION]
    for problem in problems:
        parts.append(_problem(runs, problem))
    parts.append(_verdicts(runs, problems))
    parts.append(_knowledge(runs))
    return "\n".join(parts)


INTRODUCTION = f"""# Searches beside each other

Written by `python -m benchmarks.search`. Shares of the best known front on {FLIGHTS} held-out flights (hypervolume up to
1.1 times the default; with one objective the best known value over the value found), median over seeds [least, most]. The
best known is the front of all contestants and of long runs together: of a seed, or of all seeds where all are judged on the
same flights (the problems of `--validation`). Processor time is that of the search, of margins and of flying; held-out
flights are not counted. A dash: a seed was not judged by then. A run that ended keeps its last share, in round brackets in
columns of flights.
"""


def _problem(runs: Runs, problem: str) -> str:
    found = curves(runs, problem)
    seeds = sorted({run["seed"] for run in runs if run["problem"] == problem})
    best = ", ".join(dict.fromkeys(f"{value:.3g}" for value in best_known(runs, problem).values()))
    heads = [f"{count:,}" for count in AT_FLIGHTS] + [f"{seconds} s" for seconds in AT_SECONDS]
    lines = [
        f"## {problem}: {PROBLEMS[problem].about}",
        "",
        f"Seeds {', '.join(map(str, seeds))}; best known {best}.",
        "",
        f"| search | seeds | {' | '.join(heads)} | flights to {ENOUGH:.0%} | seconds to {ENOUGH:.0%} | flights | at the end |",
        "|---|" + "---:|" * (len(heads) + 5),
    ]
    for name, own in found.items():
        cells = [_cell(own, count) for count in AT_FLIGHTS]
        cells += [_range(curve.within(seconds) for curve in own) for seconds in AT_SECONDS]
        cells += [_reached(own, 0, ",.0f"), _reached(own, 1, ".1f")]
        cells += [f"{median(curve.flights[-1] for curve in own):,.0f}", _range(curve.shares[-1] for curve in own)]
        lines.append(f"| {name} | {len(own)} | {' | '.join(cells)} |")
    return "\n".join([*lines, ""])


def _cell(own: list[Curve], flights: float) -> str:
    """Return the shares after so many flights, in brackets where one of the runs ended before."""
    text = _range(curve.after(flights) for curve in own)
    return f"({text})" if text != "-" and any(curve.ended(flights) for curve in own) else text


def _range(shares: Iterable[float | None]) -> str:
    """Return median and range of the shares of all seeds; a dash where one is missing."""
    known = list(shares)
    some = [share for share in known if share is not None]
    if len(some) < len(known) or not some:
        return "-"
    return f"{some[0]:.2f}" if len(some) == 1 else f"{median(some):.2f} [{min(some):.2f}, {max(some):.2f}]"


def _reached(own: list[Curve], part: int, form: str) -> str:
    """Return the median of the flights (part 0) or seconds (1) to enough, and how many seeds got there if not all did."""
    found = [curve.enough() for curve in own]
    middle = median(inf if entry is None else entry[part] for entry in found)
    missed = found.count(None)
    seeds = f"{len(found) - missed} of {len(found)} seeds" if missed else ""
    if isinf(middle):
        return seeds
    return f"{middle:{form}} ({seeds})" if seeds else f"{middle:{form}}"


def _verdicts(runs: Runs, problems: list[str]) -> str:
    """Return what the race shows of the default: flights against those of the default before, and who is ahead of it."""
    lines = [f"## The default, `{AUTO}`", ""]
    for problem in problems:
        found = curves(runs, problem)
        if AUTO not in found:
            lines.append(f"- {problem}: not raced")
            continue
        now, before = _ends(found[AUTO]), _ends(found[BEFORE]) if BEFORE in found else "not raced"
        lines.append(f"- {problem}: {now}. `{BEFORE}`: {before}. " + _ahead(found))
    return "\n".join([*lines, ""])


def _ends(own: list[Curve]) -> str:
    """Return the ends of a contestant's runs and their flights to enough of the best known, in words."""
    flights, reached = median(curve.flights[-1] for curve in own), _reached(own, 0, ",.0f")
    shares = _range(curve.shares[-1] for curve in own)
    return f"ends at {shares} after {flights:,.0f} flights, {ENOUGH:.0%} of the best known after {reached}"


def _ahead(found: dict[str, list[Curve]]) -> str:
    """Return which peers have a larger median share than the default on their seeds, and which had ended before."""
    peers = {name: own for name, own in found.items() if CONTESTANTS[name].family in ("peer", "baseline")}
    marks = [(f"{count:,} flights", lambda curve, count=count: curve.after(count)) for count in DECIDING]
    marks += [(f"{seconds} s", lambda curve, seconds=seconds: curve.within(seconds)) for seconds in AT_SECONDS]
    ahead = []
    for mark, share in marks:
        for name, own in peers.items():
            seeds = {curve.seed for curve in own}
            mine = _median(share(curve) for curve in found[AUTO] if curve.seed in seeds)
            if _median(map(share, own)) > mine:
                ahead.append(f"{name} at {mark}" + (f" ({len(own)} seeds)" if len(own) < len(found[AUTO]) else ""))
    text = "Ahead of it: " + ("; ".join(ahead) if ahead else "no peer") + "."
    ended = [
        f"{name} before {count:,}"
        for count in DECIDING
        for name, own in peers.items()
        if any(curve.ended(count) for curve in own)
    ]
    return text + (f" Ended: {'; '.join(ended)} flights." if ended else "")


def _median(shares: Iterable[float | None]) -> float:
    """Return the median over seeds; what was not judged yet counts as nothing."""
    return median([share or 0.0 for share in shares] or [0.0])


def _knowledge(runs: Runs) -> str:
    """Return what each contestant knows, its start and budget, and which runs ended early and why."""
    lines = [
        "## What each knows",
        "",
        "All start from the same first candidates of a seed: the default and points that keep the margins. What margins say of a",
        "point costs no flight.",
        "",
        "| search | first batch, later ones | flights a candidate | at most | knows |",
        "|---|---:|---:|---:|---|",
    ]
    raced = {run["contestant"] for run in runs}
    for name, entry in CONTESTANTS.items():
        if name not in raced:
            continue
        own = entry.overrides.get("search", {}).get("population", "the study's")
        batch = f"{entry.first}, {entry.batch}" if entry.peer else own
        each = entry.overrides.get("scenario.0.search", "the study's")
        most = f"{entry.most_flights:,} flights or {entry.most_seconds:g} s"
        lines.append(f"| {name} | {batch} | {each} | {most} | {entry.knows} |")
    early: dict[str, dict[str, int]] = {}
    for run in runs:
        if run["stopped"]:
            counts = early.setdefault(f"{run['contestant']}, {run['stopped']}", {})
            counts[run["problem"]] = counts.get(run["problem"], 0) + 1
    revisions = ", ".join(sorted({str(run["revision"]) for run in runs}))
    lines += ["", *(f"- stopped: {what}: {_counts(where)}" for what, where in early.items())]
    return "\n".join([*lines, "", f"Revisions: {revisions}.", ""])


def _counts(where: dict[str, int]) -> str:
    return ", ".join(f"{problem} ({count} runs)" for problem, count in where.items())
