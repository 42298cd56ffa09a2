"""The tables of a results folder: generations, history, front. Column names are told in results/README.md."""

from typing import TYPE_CHECKING, Any

import numpy as np

from objectives.problem import Evaluation
from objectives.requirements import Requirement
from tuner.documents.finalists import FINALIST_COLUMNS
from tuner.search.loop import Generation

if TYPE_CHECKING:
    from tuner.experiments.tuning.outcome import Outcome
    from tuner.study.study import Study


def generation_table(study: "Study", generations: list[Generation], record: Generation) -> Any:
    """Return one generation as a pandas table, a row for each candidate."""
    import pandas as pd

    before = sum(len(entry.points) for entry in generations) - len(record.points)
    values = study.space.values(record.points)
    evaluation = record.evaluation
    columns: dict[str, Any] = {"candidate": before + np.arange(len(record.points))}
    columns |= {f"gain:{v.name}": values[:, i] for i, v in enumerate(study.space.variables)}
    columns |= {f"objective:{o.label}": evaluation.values[:, i] for i, o in enumerate(study.objectives)}
    columns |= {f"violation:{c.objective.label}": evaluation.violations[:, i] for i, c in enumerate(study.constraints)}
    known = study.requirements
    broken = evaluation.violations[:, len(study.constraints) :]
    columns |= {f"violation:{r.label}": broken[:, i] for i, r in enumerate(known)}
    columns |= requirement_columns(known, evaluation)
    columns |= {"flown": evaluation.flown}
    columns |= {"failures": evaluation.failures, "feasible": np.all(evaluation.violations <= 0.0, axis=1)}
    return pd.DataFrame(columns)


def requirement_columns(requirements: tuple[Requirement, ...], evaluation: Evaluation) -> dict[str, Any]:
    """Return the values of the requirements as columns in SI units; an infinite value stands as inf."""
    return {
        f"requirement:{entry.label}": entry.in_file(evaluation.requirements[:, i])
        for i, entry in enumerate(requirements)
    }


def history_table(generations: list[Generation]) -> Any:
    """Return the progress of a search as a pandas table, a row for each generation."""
    import pandas as pd

    return pd.DataFrame(
        {
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
    )


def front_table(outcome: "Outcome") -> Any:
    """Return the finalists as a pandas table: default first, then the front of the search along its first objective."""
    import pandas as pd

    study, finalists = outcome.study, outcome.finalists
    rows = [0, *[int(candidate) for candidate in outcome.candidates]]
    chosen = "tuned" if outcome.feasible else "nearest"
    roles = ["default"] + [chosen if row == outcome.tuned else "" for row in range(1, len(rows))]
    columns: dict[str, Any] = {
        "point": outcome.names, "candidate": rows, "role": roles,
        **{entry.name: getattr(finalists, entry.name) for entry in FINALIST_COLUMNS},
    }  # fmt: skip
    gains = outcome.finalist_rows
    columns |= {
        f"gain:{v.name}": gains[:, c[0]] for v, c in zip(study.space.variables, study.space.columns, strict=True)
    }
    held_out = finalists.evaluation.values
    for i, objective in enumerate(study.objectives):
        columns |= {
            f"{name}:{objective.label}": values[:, i]
            for name, values in (
                ("search", finalists.search), ("held_out", held_out), ("low", finalists.low), ("high", finalists.high),
                ("gap", finalists.gap), ("gap_low", finalists.gap_low), ("gap_high", finalists.gap_high),
                ("difference", finalists.difference), ("difference_low", finalists.difference_low),
                ("difference_high", finalists.difference_high),
            )
        }  # fmt: skip
    columns |= requirement_columns(study.requirements, finalists.evaluation)
    return pd.DataFrame(columns)
