"""What a sensitivity analysis found, as data for JSON and as tables for CSV."""

from typing import TYPE_CHECKING, Any

import numpy as np

from plant.gains import gain_addresses
from tuner.analysis.sensitivity.analysis import Analysis
from tuner.analysis.sensitivity.indices import Spans
from tuner.analysis.sensitivity.scales import RANK, SCALES, VALUE
from tuner.analysis.sensitivity.variance import Shares, TwoWay
from tuner.study.study import Study

if TYPE_CHECKING:
    from pandas import DataFrame

Row = dict[str, Any]
FAILURE = "share of flights lost"
SCALE_WORDS = {
    RANK: "a sample's place among all samples, 0 the best and 1 the worst",
    VALUE: "the objective, held to the largest value of a sample that lost no flight",
}


def sensitivity_document(study: Study, analysis: Analysis, seconds: float) -> Row:
    """Return everything found, in shares of 1 and in percent where a key says so."""
    flights = sum(entry.search for entry in study.scenarios)
    return {
        "title": study.title,
        "study": study.path.name,
        "digest": study.digest(),
        "seed": study.seed,
        "base_samples": analysis.design.base,
        "candidates": len(analysis.values),
        "flights": len(analysis.values) * flights,
        "seconds": seconds,
        "lost_flights_percent": 100.0 * analysis.failed_share,
        "not_worth_flying_percent": 100.0 * analysis.screened_share,
        "scales": SCALE_WORDS,
        "variables": variables(study),
        "outputs": outputs(study),
        "indices": index_rows(study, analysis),
        "variance": variance_rows(study, analysis),
        "notes": notes(study, analysis),
    }


def outputs(study: Study) -> list[str]:
    """Return the names of what is explained, in order."""
    return [*[objective.label for objective in study.objectives], FAILURE]


def variables(study: Study) -> list[Row]:
    """Return every variable with unit, range and scale; it is uniform on that scale."""
    known = {gain.column: gain for gain in gain_addresses(study.system.cascade)}
    return [
        {"name": v.name, "unit": known[columns[0]].unit, "low": v.low, "high": v.high, "scale": v.scale}
        for v, columns in zip(study.space.variables, study.space.columns, strict=True)
    ]


def index_rows(study: Study, analysis: Analysis) -> list[Row]:
    """Return a row for each scale, output and variable."""
    rows = []
    for scale in SCALES:
        first, total = analysis.indices[scale]
        for q, output in enumerate(outputs(study)):
            for i, variable in enumerate(study.space.variables):
                spans = {"first": span(first, q, i), "total": span(total, q, i)}
                rows.append({"scale": scale, "output": output, "variable": variable.name, **spans})
    return rows


def span(spans: Spans, output: int, variable: int) -> Row:
    """Return one index with its interval."""
    return {name: float(part[output, variable]) for name, part in spans._asdict().items()}


def variance_rows(study: Study, analysis: Analysis) -> list[Row]:
    """Return a row for each objective: what gains, scenario and interaction make of the variance of its metric, in percent."""
    rows = []
    for objective, found in zip(study.objectives, analysis.variance, strict=True):
        row: Row = {"objective": objective.label, "metric": objective.metric.text, "unit": objective.metric.unit}
        rows.append(row | {"candidates": analysis.candidates} | shares_row(found))
    return rows


def shares_row(found: TwoWay | None) -> Row:
    """Return the decomposition of one metric; null where there was nothing to decompose."""
    if found is None:
        return {"components_percent": None, "turbulence_percent": None, "sum_of_squares_percent": None}
    return {
        "components_percent": percent(found.of_components),
        "turbulence_percent": 100.0 * found.of_components.turbulence,
        "sum_of_squares_percent": percent(found.of_squares),
    }


def percent(shares: Shares) -> dict[str, float]:
    """Return shares in percent."""
    return {name: 100.0 * share for name, share in shares._asdict().items()}


def notes(study: Study, analysis: Analysis) -> list[str]:
    """Return what has to be known to read the figures."""
    said = []
    if analysis.failed_share > 0.0:
        said.append(
            f"{100.0 * analysis.failed_share:.1f} % of the samples lost at least one flight; on the scale of ranks they count "
            "as bad, not as far off."
        )
    if analysis.screened_share > 0.0:
        said.append(
            f"{100.0 * analysis.screened_share:.1f} % of the samples break a hard requirement; a search would not fly them, "
            "here they were flown, for the indices need all of the ranges. Narrower ranges give indices of what a search sees."
        )
    if analysis.candidates < 2:
        said.append("Fewer than two independent samples completed every flight, so no variance could be decomposed.")
    constant = [
        output
        for output, column in zip(outputs(study), np.column_stack([analysis.values, analysis.failures]).T, strict=True)
        if np.ptp(column, axis=0) == 0.0
    ]
    if constant:
        said.append(f"The same for every sample, so nothing explains it: {', '.join(constant)}.")
    return said


def index_table(study: Study, analysis: Analysis) -> "DataFrame":
    """Return `index_rows` as a pandas table, the parts of an interval in columns of their own."""
    import pandas as pd

    rows = [
        {"scale": row["scale"], "output": row["output"], "variable": row["variable"]}
        | {f"{order}_{part}": row[order][part] for order in ("first", "total") for part in ("value", "low", "high")}
        for row in index_rows(study, analysis)
    ]
    return pd.DataFrame(rows)


def variance_table(study: Study, analysis: Analysis) -> "DataFrame":
    """Return `variance_rows` as a pandas table; percentages in columns of their own."""
    import pandas as pd

    rows = []
    for row, found in zip(variance_rows(study, analysis), analysis.variance, strict=True):
        flat = {key: row[key] for key in ("objective", "metric", "unit", "candidates")}
        if found is not None:
            flat |= {f"components:{name}": share for name, share in percent(found.of_components).items()}
            flat |= {f"squares:{name}": share for name, share in percent(found.of_squares).items()}
        rows.append(flat)
    return pd.DataFrame(rows)


def sample_table(study: Study, analysis: Analysis) -> "DataFrame":
    """Return every sample as a pandas table: block A, B or AB of a variable, gains, objectives, share of flights lost."""
    import pandas as pd

    names = [variable.name for variable in study.space.variables]
    blocks = ["A", "B", *[f"AB:{name}" for name in names]]
    gains = study.space.values(analysis.design.points)
    columns: Row = {"block": [block for block in blocks for _ in range(analysis.design.base)]}
    columns |= {f"gain:{name}": gains[:, i] for i, name in enumerate(names)}
    columns |= {f"objective:{o.label}": analysis.values[:, i] for i, o in enumerate(study.objectives)}
    return pd.DataFrame(columns | {"failures": analysis.failures, "kept": analysis.kept})
