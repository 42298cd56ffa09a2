"""The document of a fit."""

from collections.abc import Sequence

import numpy as np

from tuner.extensions.plant_fit.advice import notes_of
from tuner.extensions.plant_fit.document import (
    NoiseRow,
    OutputRow,
    PlantFitDocument,
    PlantNumber,
    RecordRow,
    RivalRow,
    TransferFunctionRow,
)
from tuner.extensions.plant_fit.estimate import Projection, share
from tuner.extensions.plant_fit.intervals import NORMAL_QUANTILE, FittedPlant, Number
from tuner.extensions.plant_fit.reading import Experiment
from tuner.extensions.plant_fit.study_file import Signals

Array = np.ndarray
MAX_LAG = 25


def fit_document(
    experiments: Sequence[Experiment], plants: Sequence[FittedPlant], signals: Signals, file: str | None
) -> PlantFitDocument:
    """Return the document of fitted plants, one for each output."""
    outputs = [_output(plant, signals, i) for i, plant in enumerate(plants)]
    return PlantFitDocument(
        records=[_record(each) for each in experiments],
        inputs=list(signals.inputs),
        outputs=outputs,
        warnings=[warning for plant, row in zip(plants, outputs, strict=True) for warning in _warnings(plant, row)],
        file=file,
    )


def _record(experiment: Experiment) -> RecordRow:
    notes = (
        [] if experiment.is_regular else ["samples are not equally spaced; the noise model counts them as if they were"]
    )
    return RecordRow(
        file=experiment.file,
        sha256=experiment.sha256,
        samples=len(experiment.time),
        duration=float(experiment.time[-1] - experiment.time[0]),
        period=experiment.period,
        notes=notes,
    )


def _output(plant: FittedPlant, signals: Signals, i: int) -> OutputRow:
    solution, name = plant.solution, signals.outputs[i]
    numbers = [
        (signals.inputs[j], number)
        for j in range(len(signals.inputs))
        for number in plant.numbers(j, (signals.units[signals.inputs[j]], signals.units[name]))
    ]
    chosen = next(each for each in plant.chosen.rivals if each.structure == solution.structure)
    noise = signals.noise[i]
    return OutputRow(
        output=name,
        unit=signals.units[name],
        structure=solution.structure.name,
        fit=share(plant.chosen.projection, solution),
        held_out=chosen.held_out,
        transfer_functions=[_transfer_function(plant, signals, j) for j in range(len(signals.inputs))],
        numbers=[_number(*pair) for pair in numbers],
        rivals=[
            RivalRow(
                structure=each.structure.name,
                parameters=each.structure.n_free * len(signals.inputs),
                fit=share(Projection(plant.chosen.problem, each.structure), each.solution),
                held_out=each.held_out,
                ratio=each.score,
                error=each.error,
                chosen=each is chosen,
            )
            for each in plant.chosen.rivals
        ],
        noise=NoiseRow(
            white=noise.white,
            coloured=noise.coloured,
            correlation_time=noise.correlation_time,
            prediction_error=float(np.sqrt(plant.variance)),
            correlated=correlated_share(plant),
            order=len(solution.noise),
            outliers=sum(len(each) for each in plant.chosen.problem.outliers),
        ),
        notes=notes_of(plant, signals, i, [number for _, number in numbers]),
    )


def _transfer_function(plant: FittedPlant, signals: Signals, j: int) -> TransferFunctionRow:
    numerator, denominator = plant.coefficients(j)
    return TransferFunctionRow(
        input=signals.inputs[j],
        numerator=numerator.tolist(),
        denominator=denominator.tolist(),
        dead_time=float(plant.solution.dead_times[j]),
    )


def _number(input: str, number: Number) -> PlantNumber:
    low, high = (float(end) if np.isfinite(end) else None for end in (number.low, number.high))
    return PlantNumber(
        input=input,
        name=number.name,
        value=float(number.value),
        low=low,
        high=high,
        unit="1" if number.unit == "1/1" else number.unit.replace("1/1/", "1/"),
        identified=number.is_identified,
    )


def autocorrelation(errors: Array, max_lag: int = MAX_LAG) -> tuple[Array, float]:
    """Return autocorrelations from lag 1 on and their 95 % bound."""
    centred = errors - errors.mean()
    top = min(max_lag, len(errors) // 4)
    power = float(centred @ centred)
    values = np.array([float(centred[k:] @ centred[:-k]) / power for k in range(1, top + 1)])
    return values, NORMAL_QUANTILE / float(np.sqrt(len(errors)))


def correlated_share(plant: FittedPlant) -> float:
    """Return the share of autocorrelations beyond their bound."""
    values, bound = autocorrelation(plant.solution.errors)
    return float(np.mean(np.abs(values) > bound))


def _warnings(plant: FittedPlant, row: OutputRow) -> list[str]:
    warnings = []
    if row.noise.correlated > 0.2:
        warnings.append(
            f"{row.output}: {row.noise.correlated:.0%} of the autocorrelations of the prediction errors are beyond their bound; "
            "intervals may be too narrow"
        )
    if row.fit < 0.5:
        warnings.append(
            f"{row.output}: the model explains {max(row.fit, 0.0):.0%}; another input may move this output, or it is not linear"
        )
    if any(plant.chosen.problem.has_start):
        return [*warnings, f"{row.output}: the record does not begin at rest; its initial state is estimated"]
    return warnings
