"""The weight as a datum: mean lift at the commands that carry the vehicle.

A flight whose lift hardly follows its commands identifies no thrust curve, but its mean lift does identify the thrust at the mean
command: the vehicle is carried. Two numbers of each flight count: its mean lift, and the change of its lift from begin to
end, which is a battery's.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tuner.extensions.vehicle_fit.samples import OUTPUTS, LogSegment

Array = NDArray[np.float64]

MEAN_STD, CHANGE_STD = 0.02, 0.03
"""Standard deviations of mean lift and of its change over a flight, in weights: the model has neither the lift of horizontal
speed nor a mean climb through the air. At 5 m/s a rotor lifts 3 to 10 % more; 0.2 m/s of climb take 1 %.
"""
LIFT = OUTPUTS.index("lift")


def weigh(samples: Sequence[LogSegment], masks: Sequence[Array], series: Sequence[Array], gravity: float) -> Array:
    """Return mean lift and change of lift (2 flights, ...), in standard deviations.

    Args:
        samples: Segments of logs.
        masks: 0 or 1 for each sample (m,) of a segment: 1 where it counts.
        series: Outputs, their residuals or derivatives (m, 4, ...) of each segment.
        gravity: Of the vehicle's place [m/s2].
    """
    rows = [np.zeros((0, *series[0].shape[2:]))]
    for log in sorted({part.log for part in samples}):
        chosen = [
            (part, mask > 0.0, entry)
            for part, mask, entry in zip(samples, masks, series, strict=True)
            if part.log == log
        ]
        lift = np.concatenate([entry[mask, LIFT] for _, mask, entry in chosen])
        age = np.concatenate([part.output_age[mask] for part, mask, _ in chosen])
        if len(age) > 1:
            rows.append(np.stack([lift.mean(axis=0) / MEAN_STD, _slope(age, lift) / CHANGE_STD]) / gravity)
    return np.concatenate(rows)


def _slope(age: Array, lift: Array) -> Array:
    """Return the slopes (...) of straight lines through series (m, ...) over ages (m,)."""
    off = age - age.mean()
    return np.tensordot(off, lift, 1) / float(off @ off)
