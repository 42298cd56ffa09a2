"""One law on y'' = u + d, b0 = 1, with a disturbance d that is linear within each period; integrated exactly."""

import numpy as np

from plant.laws.channel import Applied, Channel, Measured, Setpoint

REST, STILL = Setpoint(0.0, 0.0, 0.0), Measured(0.0, 0.0)


def fly(law, gains, h, slopes, start=STILL):
    """Fly a law as it flies, d' = slopes[k] in period k; slopes: numbers, or a function of (y, y', d) that chooses them.

    Returns y and y' (K,) at the control instants.
    """
    constants, channel, applied = law.prepare(gains, h), Channel(1.0, 0.0), Applied(0.0, 0.0)
    y, v, d = start.value, start.rate, 0.0
    memory, found = law.start(constants, start, 0.0), []
    for slope in slopes:
        slope = slope(y, v, d) if callable(slope) else slope
        u, memory = law.step(memory, constants, channel, REST, Measured(y, v), applied, h)
        applied = Applied(u, 0.0)
        found.append((y, v))
        y += h * v + 0.5 * h * h * (u + d) + slope * h**3 / 6.0
        v += h * (u + d) + 0.5 * h * h * slope
        d += h * slope
    return np.array(found).T
