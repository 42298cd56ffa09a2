"""Results of a sensitivity analysis for JSON and CSV."""

import numpy as np

from tuner.documents.parts import SampledValue
from tuner.extensions.sensitivity.analysis import Analysis
from tuner.extensions.sensitivity.document import (
    IndexRow,
    SensitivityDocument,
    SensitivityVariable,
    VarianceRow,
    VarianceShares,
)
from tuner.extensions.sensitivity.indices import RANK, SCALES, VALUE, Spans
from tuner.extensions.sensitivity.variance import VarianceComponents
from tuner.store.columns import Columns, columns_of
from tuner.study.study import TuningStudy

FAILURE = "share of flights lost"
SCALE_WORDS = {
    RANK: "a sample's place among all samples, 0 the best and 1 the worst",
    VALUE: "the objective, held to the largest value of a sample that lost no flight",
}


def sensitivity_document(study: TuningStudy, analysis: Analysis, seconds: float) -> SensitivityDocument:
    """Return the document: in shares of 1, or in percent if the key has that unit."""
    flights = sum(entry.search for entry in study.scenarios)
    return SensitivityDocument(
        title=study.title,
        study=study.path.name,
        digest=study.digest(),
        seed=study.seed,
        base_samples=analysis.design.base,
        candidates=len(analysis.values),
        flights=len(analysis.values) * flights,
        seconds=seconds,
        lost_flights_percent=100.0 * analysis.failed_share,
        not_worth_flying_percent=100.0 * analysis.screened_share,
        scales=SCALE_WORDS,
        variables=variables(study),
        outputs=outputs(study),
        indices=index_rows(study, analysis),
        variance=variance_rows(study, analysis),
        notes=notes(study, analysis),
    )


def outputs(study: TuningStudy) -> list[str]:
    """Return the names of the outputs, in order."""
    return [*[objective.label for objective in study.objectives], FAILURE]


def variables(study: TuningStudy) -> list[SensitivityVariable]:
    """Return every variable with unit, range and scale; it is uniform on that scale."""
    gains = {gain.column: gain for gain in study.system.gains}
    return [
        SensitivityVariable(name=v.name, unit=gains[columns[0]].unit, low=v.low, high=v.high, scale=v.scale)
        for v, columns in zip(study.space.variables, study.space.columns, strict=True)
    ]


def index_rows(study: TuningStudy, analysis: Analysis) -> list[IndexRow]:
    """Return a row for each scale, output and variable."""
    return [
        IndexRow(
            scale=scale,
            output=output,
            variable=variable.name,
            first=span(analysis.indices[scale].first, q, i),
            total=span(analysis.indices[scale].total, q, i),
        )
        for scale in SCALES
        for q, output in enumerate(outputs(study))
        for i, variable in enumerate(study.space.variables)
    ]


def span(spans: Spans, output: int, variable: int) -> SampledValue:
    """Return one index with its interval."""
    return SampledValue(**{name: float(part[output, variable]) for name, part in spans._asdict().items()})


def variance_rows(study: TuningStudy, analysis: Analysis) -> list[VarianceRow]:
    """Return a row of variance components for each objective, in percent."""
    return [
        VarianceRow(
            objective=objective.label,
            metric=objective.metric.text,
            unit=objective.metric.unit,
            candidates=analysis.candidates,
            components_percent=None if anova is None else percent(anova.of_components),
            turbulence_percent=None if anova is None else 100.0 * anova.of_components.turbulence,
            sum_of_squares_percent=None if anova is None else percent(anova.of_squares),
        )
        for objective, anova in zip(study.objectives, analysis.variance, strict=True)
    ]


def percent(shares: VarianceComponents) -> VarianceShares:
    """Return shares in percent."""
    return VarianceShares(**{name: 100.0 * share for name, share in shares._asdict().items()})


def notes(study: TuningStudy, analysis: Analysis) -> list[str]:
    """Return notes on the interpretation of the figures."""
    sentences = []
    if analysis.failed_share > 0.0:
        sentences.append(
            f"{100.0 * analysis.failed_share:.1f} % of the samples lost at least one flight; on the scale of ranks they count "
            "as bad, not as far off."
        )
    if analysis.screened_share > 0.0:
        sentences.append(
            f"{100.0 * analysis.screened_share:.1f} % of the samples violate a hard requirement; a search would skip them, "
            "but the indices need all of the ranges. Narrower ranges give the indices over a search's candidates."
        )
    if analysis.candidates < 2:
        sentences.append(
            "Fewer than two independent samples completed every flight, so no variance could be decomposed."
        )
    constant = [
        output
        for output, column in zip(outputs(study), np.column_stack([analysis.values, analysis.failures]).T, strict=True)
        if np.ptp(column, axis=0) == 0.0
    ]
    if constant:
        sentences.append(f"The same for every sample, so nothing explains it: {', '.join(constant)}.")
    return sentences


def index_table(study: TuningStudy, analysis: Analysis) -> Columns:
    """Return `index_rows` as a table: a column for each part of an interval."""
    rows = []
    for row in index_rows(study, analysis):
        ends = {
            f"{order}_{part}": value
            for order, index in (("first", row.first), ("total", row.total))
            for part, value in index.content().items()
        }
        rows.append({"scale": row.scale, "output": row.output, "variable": row.variable, **ends})
    return columns_of(rows)


def variance_table(study: TuningStudy, analysis: Analysis) -> Columns:
    """Return `variance_rows` as a table; percentages in columns of their own."""
    rows = []
    for row in variance_rows(study, analysis):
        flat = row.model_dump(include={"objective", "metric", "unit", "candidates"})
        for name, shares in (("components", row.components_percent), ("squares", row.sum_of_squares_percent)):
            if shares is not None:
                flat |= {f"{name}:{part}": share for part, share in shares.content().items()}
        rows.append(flat)
    return columns_of(rows)


def sample_table(study: TuningStudy, analysis: Analysis) -> Columns:
    """Return every sample as a table: block A, B or AB of a variable, gains, objectives, share of flights lost."""
    names = [variable.name for variable in study.space.variables]
    blocks = ["A", "B", *[f"AB:{name}" for name in names]]
    gains = study.space.values(analysis.design.points)
    columns: Columns = {"block": [block for block in blocks for _ in range(analysis.design.base)]}
    columns |= {f"gain:{name}": gains[:, i] for i, name in enumerate(names)}
    columns |= {f"objective:{o.label}": analysis.values[:, i] for i, o in enumerate(study.objectives)}
    return columns | {"failures": analysis.failures, "kept": analysis.passes_screening}
