"""The tables of the published problems: wins, ties and losses of the tool's search, where peers lead, evaluations saved."""

from math import inf
from statistics import median

from benchmarks.search.published.contestants import CONTESTANTS
from benchmarks.search.published.play import EVALUATIONS, MARKS, STEP, PublishedRun, RunKey
from benchmarks.search.published.suite import SUITE

Runs = dict[RunKey, PublishedRun]
# A share of the hypervolume is better by more than this; a gap by this share of it, unless both are below the least.
SHARE, GAP, MIN_GAP = 0.01, 0.1, 1e-4
# Largest number of problems that are listed by name.
FEW = 10
# Name of the tool's search in documents, to which a revision may be added.
TOOL = "gaussian_process"

INTRODUCTION = f"""# Published problems

Written by `python -m benchmarks.search.published --table`; {len(SUITE)} problems of one to three objectives, sources in
`benchmarks/search/published`. A score is the share of the hypervolume of the reference front (reference point: nadir + 10 % of
the range); with one objective, the gap to the best value in the literature over that value, at least 1. All start from the same
{STEP} points of a Latin hypercube. Scores are read every {STEP} evaluations: 50 stands for 48, 100 for 96. Medians over the seeds
that both played.
"""


def is_gap(problem: str) -> bool:
    """Return True if less is better."""
    return SUITE[problem].optimum is not None


def median_score(runs: Runs, problem: str, contestant: str, mark: int, seeds: set[int]) -> float | None:
    """Return the median score over seeds after so many evaluations; None where a run ended before."""
    scores: list[float] = []
    for seed in seeds:
        run = runs[RunKey(problem, contestant, seed)]
        if len(run.scores) < mark // STEP:
            return None
        score = run.score_at(mark)
        scores.append(inf if score is None else score)
    return median(scores) if scores else None


def compare(problem: str, score: float, other: float) -> int:
    """Return 1 where a median score is better than another, -1 where it is worse, 0 for a tie."""
    if not is_gap(problem):
        return (score > other + SHARE) - (score < other - SHARE)
    score, other = max(score, MIN_GAP), max(other, MIN_GAP)
    return (score < (1.0 - GAP) * other) - (other < (1.0 - GAP) * score)


def common_seeds(runs: Runs, problem: str, *contestants: str) -> set[int]:
    """Return the seeds that all contestants played on a problem."""
    return set.intersection(
        *[{key.seed for key in runs if key[:2] == (problem, contestant)} for contestant in contestants]
    )


def verdicts(runs: Runs, tool: str, peer: str, mark: int) -> dict[str, int]:
    """Return the comparison of tool and peer by problem, where both reached a mark."""
    found: dict[str, int] = {}
    for problem in SUITE:
        seeds = common_seeds(runs, problem, tool, peer)
        scores = [median_score(runs, problem, contestant, mark, seeds) for contestant in (tool, peer)]
        if scores[0] is not None and scores[1] is not None:
            found[problem] = compare(problem, scores[0], scores[1])
    return found


def evaluations_to_reach(runs: Runs, problem: str, tool: str, baseline: str) -> int | None:
    """Return the evaluations after which the tool has the baseline's last score, medians over seeds; None where never."""
    seeds = common_seeds(runs, problem, tool, baseline)
    goal = median_score(runs, problem, baseline, EVALUATIONS, seeds)
    for count in range(STEP, EVALUATIONS + 1, STEP):
        score = median_score(runs, problem, tool, count, seeds)
        if score is not None and goal is not None and (score <= goal if is_gap(problem) else score >= goal):
            return count
    return None


def markdown(runs: Runs, tool: str, baseline: str) -> str:
    """Return the tables for people: of the tool's search, and against the baseline, another revision of it."""
    peers = [name for name in dict.fromkeys(key.contestant for key in runs) if name != tool]
    peers.sort(key=lambda name: list(CONTESTANTS).index(name) if name in CONTESTANTS else -1)
    parts = [INTRODUCTION, _wins(runs, tool, peers), _losses(runs, tool, peers), _scores(runs, tool)]
    if baseline != tool:
        parts.append(_savings(runs, tool, baseline))
    return "\n".join(parts)


def _wins(runs: Runs, tool: str, peers: list[str]) -> str:
    """Return the table of wins, ties and losses, and the reasons why runs ended early."""
    lines = [
        f"## `{tool}` against others",
        "",
        f"Wins/ties/losses; a win: a share larger by {SHARE}, or a gap smaller by {GAP:.0%}. In brackets: problems, where not",
        "those of the second column, because runs had ended before.",
        "",
        "| other search | problems | seeds | batch | " + " | ".join(map(str, MARKS)) + " | seconds a run |",
        "|---|---:|---:|---:|" + "---:|" * (len(MARKS) + 1),
    ]
    reasons = []
    for peer in peers:
        own = {key: run for key, run in runs.items() if key.contestant == peer}
        problems = {key.problem for key, run in own.items() if run.scores}
        seeds = sorted({len(common_seeds(runs, problem, tool, peer)) for problem in problems})
        cells = []
        for mark in MARKS:
            found = list(verdicts(runs, tool, peer, mark).values())
            counts = "/".join(str(found.count(value)) for value in (1, 0, -1))
            cells.append(counts + (f" ({len(found)})" if len(found) < len(problems) else ""))
        batch = CONTESTANTS[peer].batch if peer in CONTESTANTS else STEP
        seconds = f"{median(run.seconds for run in own.values()):.1f}"
        span = "-".join(str(count) for count in dict.fromkeys((seeds[0], seeds[-1]))) if seeds else "0"
        lines.append(f"| {peer} | {len(problems)} | {span} | {batch} | {' | '.join(cells)} | {seconds} |")
        if len(problems) <= FEW:
            reasons.append(f"- {peer} played {', '.join(sorted(problems))} only: it takes long")
        stopped = [run.stopped for run in own.values() if run.stopped]
        reasons += [f"- {peer}: {reason} ({stopped.count(reason)} runs)" for reason in sorted(set(stopped))]
    return "\n".join([*lines, "", *reasons, ""])


def _losses(runs: Runs, tool: str, peers: list[str]) -> str:
    """Return the problems where others are better: the best of them, its score, and the number of those ahead."""
    lines = [
        "## Where others are better",
        "",
        f"The score of `{tool}`, that of the best other search, its name, and how many are better.",
        "",
        "| problem | " + " | ".join(map(str, MARKS)) + " |",
        "|---|" + "---|" * len(MARKS),
    ]
    peers = [peer for peer in peers if not peer.startswith(TOOL)]
    for problem in SUITE:
        cells = [_lead(runs, problem, tool, peers, mark) for mark in MARKS]
        if any(cells):
            lines.append(f"| {problem} | {' | '.join(cells)} |")
    return "\n".join([*lines, ""])


def _lead(runs: Runs, problem: str, tool: str, peers: list[str], mark: int) -> str:
    """Return the best of the peers that are better on a problem, "" where none is."""
    ahead: list[tuple[float, float, str]] = []
    for peer in peers:
        seeds = common_seeds(runs, problem, tool, peer)
        score, other = (median_score(runs, problem, name, mark, seeds) for name in (tool, peer))
        if score is not None and other is not None and compare(problem, score, other) < 0:
            ahead.append((other, score, peer))
    if not ahead:
        return ""
    other, score, peer = min(ahead) if is_gap(problem) else max(ahead)
    return f"{_text(score)}, {_text(other)} {peer} ({len(ahead)})"


def _scores(runs: Runs, tool: str) -> str:
    """Return the tool's scores by problem."""
    lines = [
        f"## Scores of `{tool}`",
        "",
        "| problem | variables, objectives, constraints | " + " | ".join(map(str, MARKS)) + " | seeds |",
        "|---|---:|" + "---:|" * (len(MARKS) + 1),
    ]
    for problem, entry in SUITE.items():
        seeds = common_seeds(runs, problem, tool)
        scores = [median_score(runs, problem, tool, mark, seeds) for mark in MARKS]
        if seeds:
            name = f"{problem} (gap)" if is_gap(problem) else problem
            sizes = f"{entry.dimension}, {entry.n_objectives}, {entry.n_constraints}"
            lines.append(f"| {name} | {sizes} | {' | '.join(map(_text, scores))} | {len(seeds)} |")
    return "\n".join([*lines, ""])


def _savings(runs: Runs, tool: str, baseline: str) -> str:
    """Return by problem the evaluations of the tool to the baseline's last score."""
    reached = {
        problem: evaluations_to_reach(runs, problem, tool, baseline)
        for problem in SUITE
        if common_seeds(runs, problem, tool, baseline)
    }
    counts = [count for count in reached.values() if count is not None]
    middle = f"{EVALUATIONS / median(counts):.1f} times fewer in the median" if counts else "none"
    lines = [
        f"## Evaluations to what `{baseline}` has after {EVALUATIONS}",
        "",
        f"{len(counts)} of {len(reached)} problems get there, with {middle}.",
        "",
        ", ".join(f"{problem} {count or 'never'}" for problem, count in reached.items()),
    ]
    return "\n".join([*lines, ""])


def _text(score: float | None) -> str:
    """Return a score, a dash for none, "infeasible" for no feasible point."""
    if score is None:
        return "-"
    return "infeasible" if score == inf else f"{score:.3g}"
