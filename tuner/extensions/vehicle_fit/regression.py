"""Forward and inverse ordinary least squares: the start of a fit, and bounds of the inertias.

Angular acceleration is regressed on torque and torque on angular acceleration. Noise in the regressor makes either too small, so
the true inertia lies between the two, and their distance shows the error that a single regression hides.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plant.quadrotor.vehicle import Vehicle
from tuner.extensions.vehicle_fit.model import Actuator, lagging, predicted
from tuner.extensions.vehicle_fit.parameters import NODES, ParameterSpace
from tuner.extensions.vehicle_fit.samples import LogSegment

Array = NDArray[np.float64]

LAGS = 0.01 * 2.0 ** np.arange(0.0, 4.5, 0.5)
"""Time constants that are tried, up and down alike [s]."""
SMOOTHED = 0.04
"""Time over which changes of the rates are taken [s]; shorter ones are noise of the gyro."""
# The least thrust of a node as a share of the prior's, where a parabola fitted to a narrow range dips below.
MIN_SHARE = 0.2


class RegressionBounds(NamedTuple):
    """Inertia [kg m2] from forward and from inverse regression."""

    acceleration_on_torque: float
    torque_on_acceleration: float


def initial_estimate(space: ParameterSpace, samples: tuple[LogSegment, ...], vehicle: Vehicle) -> Array:
    """Return an initial estimate: the lag that explains lift and turning best, thrust curve and inertias with it."""
    tried = [_point(space, samples, vehicle, lag) for lag in LAGS.tolist()]
    return max(tried, key=lambda entry: entry[1])[0]


def forward_and_inverse_regression(
    space: ParameterSpace, point: Array, samples: tuple[LogSegment, ...], vehicle: Vehicle
) -> tuple[RegressionBounds, ...]:
    """Return the inertias about x, y and z from both regressions: with the rotors of a point."""
    numbers = space.numbers(point)
    actuator = Actuator(numbers.lag_up, numbers.lag_down, numbers.dead_time)
    pairs = [_smoothed(part, predicted(part, lagging(part, [actuator])[0], numbers, vehicle)) for part in samples]
    bounds = []
    for k, inertia in enumerate(numbers.inertia):
        measured, model = (np.concatenate([pair[i][:, k] for pair in pairs]) for i in (0, 1))
        product = float(measured @ model)
        bounds.append(
            RegressionBounds(inertia * float(model @ model) / product, inertia * product / float(measured @ measured))
        )
    return tuple(bounds)


def _point(space: ParameterSpace, samples: tuple[LogSegment, ...], vehicle: Vehicle, lag: float) -> tuple[Array, float]:
    """Return a lag's point, and its explained share of lift and turning."""
    point, names = space.center, space.names
    at = {name: k for k, name in enumerate(names)}
    point[[at["lag_up"], at["lag_down"]]] = np.log(lag)
    lagged = [lagging(part, [Actuator(lag, lag, 0.0)])[0] for part in samples]
    point[at["thrust.30"] : at["thrust.100"] + 1] += _curve(space, samples, lagged)
    numbers = space.numbers(point)
    pairs = [
        _smoothed(part, predicted(part, late, numbers, vehicle)) for part, late in zip(samples, lagged, strict=True)
    ]
    explained = 0.0
    for k, axis in enumerate("xy"):
        measured, model = (np.concatenate([pair[i][:, k] for pair in pairs]) for i in (0, 1))
        product, model_square, measured_square = measured @ model, float(model @ model), float(measured @ measured)
        if product > 0.0:
            share = float(product) ** 2 / (model_square * measured_square)
            # Geometric mean of the two regressions.
            change = np.clip(0.5 * np.log(model_square / measured_square), -1.5, 1.5)
            point[at[f"inertia.{axis}"]] += change if share > 0.2 else 0.0
            explained += share
    return point, explained + _lift_share(samples, lagged)


def _curve(space: ParameterSpace, samples: tuple[LogSegment, ...], lagged: list[Array]) -> Array:
    """Return log ratios of the thrusts at the nodes to the prior's: from a parabola through the lift."""
    numbers = space.numbers(space.center)
    columns = np.concatenate([np.column_stack([np.full(len(x), 4.0), x.sum(1), (x * x).sum(1)]) for x in lagged])
    lift = numbers.mass * np.concatenate([part.lift for part in samples])
    # As firm as the prior where the commands hardly move: a curve of the prior's form.
    weight = 0.03 * len(lift)
    form = np.vander(NODES, 3, increasing=True)
    scale = float(np.sum(lift) / np.sum(columns @ np.linalg.solve(form, numbers.thrust)))
    rows = np.concatenate([columns, np.sqrt(weight) * form])
    coefficients = np.linalg.lstsq(rows, np.concatenate([lift, np.sqrt(weight) * scale * numbers.thrust]), rcond=None)[
        0
    ]
    return np.log(np.clip(form @ coefficients / numbers.thrust, MIN_SHARE, 1.0 / MIN_SHARE))


def _lift_share(samples: tuple[LogSegment, ...], lagged: list[Array]) -> float:
    total = np.concatenate([(x * x).sum(1) for x in lagged])
    lift = np.concatenate([part.lift for part in samples])
    spread = float(np.std(total) * np.std(lift))
    return float(np.mean((total - total.mean()) * (lift - lift.mean())) / spread) ** 2 if spread > 0.0 else 0.0


def _smoothed(part: LogSegment, model: Array) -> tuple[Array, Array]:
    """Return measured and modeled changes of the rates over `SMOOTHED`: without their means."""
    width = max(round(SMOOTHED / (part.period * part.share)), 1)
    count = len(model) // width * width
    pair = [series[:count, :3].reshape(-1, width, 3).sum(axis=1) for series in (part.measured, model)]
    return pair[0] - pair[0].mean(axis=0), pair[1] - pair[1].mean(axis=0)
