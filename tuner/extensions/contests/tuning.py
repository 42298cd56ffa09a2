"""A contender ready for the comparison: the gains it is flown at and the front behind them, both picked before it."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from plant.texts import PlainTable
from tuner.experiments.compare.flying import ComparedPoint, PreparedContender, comparison_problem
from tuner.experiments.tuning.ending import contender_ending
from tuner.experiments.tuning.outcome import Outcome
from tuner.experiments.tuning.run import TuningRun
from tuner.extensions.contests.study import Contest
from tuner.extensions.contests.terms import terms_of
from tuner.search.front import pick
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder
from tuner.store.manifest import FILE as MANIFEST
from tuner.study.comparison import Contender
from tuner.study.study import TuningStudy
from tuner.text.toml_text import toml_text, with_paths

GIVEN = "given"
"""Name of the point of a contender that is flown as given."""


def prepare(
    contest: Contest, contender: Contender, folder: Folder, watcher: Watcher, threads: int | None
) -> PreparedContender:
    """Tune a contender into a results folder, or take its given gains."""
    problem = comparison_problem(contest, contender)
    if not contender.tuned:
        entry = ComparedPoint(contender, GIVEN, contender.study.default_row, problem)
        return PreparedContender(entry, "its gains are given", None, None, 0, [])
    study, place = contender_study(contest, contender, folder), place_of(contender)
    outcome = TuningRun(study, Folder.open_or_create(folder.path / place), watcher, threads=threads).carry_out()
    folder.written(f"{place}/{MANIFEST}")

    def entry_of(finalist: int) -> ComparedPoint:
        candidate = int(outcome.candidates[finalist - 1]) if finalist else -1
        values, name = outcome.finalists.evaluation.values[finalist], outcome.names[finalist]
        return ComparedPoint(contender, name, outcome.gains(finalist), problem, candidate, values)

    chosen, why = compared_at(outcome)
    offered = [entry_of(row) for row in np.flatnonzero(outcome.finalists.non_dominated).tolist()]
    compared = entry_of(chosen)
    ending = () if outcome.feasible else tuple(contender_ending(contender.name, compared.point, outcome.obstacles))
    searched = outcome.generations[-1].flights + outcome.survivors.flights
    return PreparedContender(compared, why, offered, place, outcome.flights, outcome.warnings, ending, searched)


def place_of(contender: Contender) -> str:
    """Return the folder of a contender's results in that of the contest."""
    return f"contenders/{contender.slug}"


def contender_study(contest: Contest, contender: Contender, folder: Folder) -> TuningStudy:
    """Write a contender's study file into the contest's folder; return the study."""
    name, alone = f"{place_of(contender)}.toml", content_alone(contest, contender)
    folder.write_text(name, toml_text(alone))
    return study_at(folder.path / name, contender, alone)


def compared_at(outcome: Outcome) -> tuple[int, str]:
    """Return the finalist a contender is compared at and why: what the pick rule picks from its held-out front.

    A study on its own prefers points that beat its default everywhere. Contenders have different defaults, and one whose
    default is poor must not be held to it.
    """
    rows = np.flatnonzero(outcome.finalists.non_dominated)
    if len(rows) == 0:
        return outcome.tuned, outcome.why
    labels = [objective.label for objective in outcome.study.objectives]
    chosen, why = pick(outcome.study.pick, outcome.finalists.evaluation.values[rows], labels)
    return int(rows[chosen]), f"{why}, on its held-out front"


def content_alone(contest: Contest, contender: Contender) -> PlainTable:
    """Return a contender as a study file's content; run alone, anywhere, it gives the same results."""
    home = contest.path.parent.resolve()
    return with_paths(contender.raw, lambda name: str(home / name))


def study_at(path: Path, contender: Contender, content: PlainTable) -> TuningStudy:
    """Return the study of a contender as that of another file; what it names is found from there."""
    if content == contender.raw:
        return replace(contender.study, path=path)
    return terms_of(content).build(path, content)
