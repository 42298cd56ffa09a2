"""Branch-free arc tangents and arc sine for SIMD code.

Calls into the C mathematical library keep LLVM from vectorising a loop, so the lanes backend evaluates these rational
approximations instead. Argument reduction and coefficients after S. L. Moshier, Cephes Mathematical Library 2.8 (atan.c):
relative error of the arc tangent below 2e-16 on the reduced range; whole functions are right to 3 ulp for arguments between
1e-150 and 1e150, far wider than any flight. A NaN may come out as a number: a check of them reads the state itself,
as `plant.quadrotor.closed_loop.status_of` does. They are written as model functions, so tests can run them on plain floats.
"""

from plant.primitives import absolute, maximum, minimum, select, sqrt

HALF_PI = 1.5707963267948966
QUARTER_PI = 0.7853981633974483
PI = 3.141592653589793
# tan(pi/8): beyond it the quotient is reduced around pi/4.
TAN_EIGHTH_TURN = 0.41421356237309503
MIN_DIVISOR = 1e-300

P4, P3, P2 = -8.750608600031904122785e-1, -1.615753718733365076637e1, -7.500855792314704667340e1
P1, P0 = -1.228866684490136173410e2, -6.485021904942025371773e1
Q4, Q3, Q2 = 2.485846490142306297962e1, 1.650270098316988542046e2, 4.328810604912902668951e2
Q1, Q0 = 4.853903996359136964868e2, 1.945506571482613964425e2


def atan_reduced(x: float) -> float:
    """Arc tangent for |x| <= tan(pi/8)."""
    z = x * x
    numerator = (((P4 * z + P3) * z + P2) * z + P1) * z + P0
    denominator = ((((z + Q4) * z + Q3) * z + Q2) * z + Q1) * z + Q0
    return x + x * z * numerator / denominator


def atan2(y: float, x: float) -> float:
    """Angle of the point (x, y) in (-pi, pi]; 0 at the origin."""
    ax, ay = absolute(x), absolute(y)
    short, long = minimum(ax, ay), maximum(maximum(ax, ay), MIN_DIVISOR)
    large = short > TAN_EIGHTH_TURN * long
    # (q - 1)/(q + 1) with q = short/long, in one division.
    reduced = select(large, short - long, short) / select(large, short + long, long)
    octant = select(large, QUARTER_PI, 0.0) + atan_reduced(reduced)
    quadrant = select(ay > ax, HALF_PI - octant, octant)
    half = select(x < 0.0, PI - quadrant, quadrant)
    return select(y < 0.0, -half, half)


def asin(x: float) -> float:
    """Arc sine of x in [-1, 1]."""
    return atan2(x, sqrt(maximum((1.0 - x) * (1.0 + x), 0.0)))
