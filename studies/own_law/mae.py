"""The mean error of an axis."""

from objectives.metrics import Metric

METRIC = Metric(
    name="mae",
    symbol="MAE",
    unit="{}",
    scope="axis",
    definition="mean of |e| over the flight",
    value=lambda view: view.meter.iae / view.context.duration,
    bound=lambda view: view.limit,
)
