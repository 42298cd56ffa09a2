"""Warnings that can be given before a run."""

from objectives.problem import Objective
from objectives.risk import minimum_samples
from plant.scenarios import HELD_OUT, SEARCH
from tuner.study.study import Study


def few_scenarios(study: Study) -> list[str]:
    """Warn of risks that ask more of the scenarios than there are."""
    return [
        f"{objective.label} rests on {have} {stream} scenarios; {need} would put five into its tail, so expect "
        f"its {stream} value to be optimistic."
        for objective in study.objectives
        for stream in (SEARCH, HELD_OUT)
        if (have := _count(study, objective, stream)) < (need := minimum_samples(objective.risk))
    ]


def _count(study: Study, objective: Objective, stream: str) -> int:
    seen = [entry for entry in study.scenarios if objective.scenario in (None, entry.spec.name)]
    return sum(entry.search if stream == SEARCH else entry.held_out for entry in seen)


def default_elsewhere(study: Study) -> list[str]:
    """Warn where the gains of `controller.default` were flown otherwise, or where one searched value replaces several."""
    given = study.table.controller.default
    if given is None:
        return []
    from tuner.analysis.judging.judge import differences
    from tuner.gains import read_gains

    said = []
    # The plant step is the simulation's own.
    differing = [
        text for text in differences(read_gains(study.path.parent / given), study) if not text.startswith("plant_step")
    ]
    if differing:
        said.append(
            f"What {given} holds differs from what this study flies: {'; '.join(differing)}. So the Default column is not what "
            "that vehicle does; change the study, or read the file for this airframe and period."
        )
    return [*said, *_merged(study)]


def _merged(study: Study) -> list[str]:
    row = study.default_row
    split = [
        f"{variable.name} ({', '.join(f'{row[column]:.4g}' for column in columns)})"
        for variable, columns in zip(study.space.variables, study.space.columns, strict=True)
        if len({float(row[column]) for column in columns}) > 1
    ]
    if not split:
        return []
    return [
        f"One value is searched where the default has several: {', '.join(split)}; tables show the first. Give axes keys of "
        'their own in [gains], for instance "yaw.kp" = {}, to search them apart.'
    ]
