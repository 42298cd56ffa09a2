"""Scale lengths and intensities of the Dryden turbulence by altitude band.

    below 1000 ft        from the altitude and W20, the mean wind at 20 ft; altitudes under 10 ft count as 10 ft
    1000 to 2000 ft      linear between the values at the two ends
    above 2000 ft        1750 ft and an isotropic sigma from the probability-of-exceedance curves

Intensity is a name or a number: W20 in m/s. A number has no exceedance probability, so above 1000 ft only names work.
The bracket 0.177 + 0.000823 h takes h in feet; everything that comes in or goes out is SI.

Source: MIL-F-8785C (1980), 3.7 and figures 7, 10, 11; MIL-HDBK-1797 (1997), appendix A (halved lengths for v and w).
Figure 7 in the tabulated form that JSBSim's FGWinds uses.
"""

from typing import NamedTuple

import numpy as np

from plant.air.turbulence_field import TRANSVERSE_FACTOR
from plant.air.units import FOOT, KNOT
from plant.errors import InputError

LOW_FLOOR, LOW_TOP, HIGH_FLOOR, HIGH_TOP = 10.0, 1000.0, 2000.0, 80000.0  # ft
HIGH_LENGTH = 1750.0  # ft
WIND_20 = {"none": 0.0, "light": 15.0 * KNOT, "moderate": 30.0 * KNOT, "severe": 45.0 * KNOT}  # m/s

_ALTITUDES = (500.0, 1750.0, 3750.0, 7500.0, 15e3, 25e3, 35e3, 45e3, 55e3, 65e3, 75e3, 80e3)  # ft
_EXCEEDANCE = {  # sigma in ft/s, exceeded with probability 1e-2, 1e-3, 1e-5
    "none": (0.0,) * 12,
    "light": (6.6, 6.9, 7.4, 6.7, 4.6, 2.7, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0),
    "moderate": (8.6, 9.6, 10.6, 10.1, 8.0, 6.6, 5.0, 4.2, 2.7, 0.0, 0.0, 0.0),
    "severe": (15.6, 17.6, 23.0, 23.6, 22.1, 20.0, 16.0, 15.1, 12.1, 7.9, 6.2, 5.1),
}


Triple = tuple[float, float, float]


class Scales(NamedTuple):
    """Scale lengths [m], in the convention of the specification, and standard deviations [m/s] of u, v, w."""

    length: Triple
    sigma: Triple


def wind_at_20_feet(intensity: str | float) -> float:
    """Return W20 [m/s], the mean wind 20 ft above ground, of a named or numeric intensity."""
    return WIND_20[intensity] if isinstance(intensity, str) else float(intensity)


def scales(spec: str, intensity: str | float, altitude: float) -> Scales:
    """Return lengths and intensities at an altitude [m] above ground.

    InputError (key "intensity"): a number above 1000 ft, where only a name selects an exceedance curve.
    """
    feet = altitude / FOOT
    w20 = wind_at_20_feet(intensity)
    if feet <= LOW_TOP:
        length, sigma = _low(max(feet, LOW_FLOOR), w20)
    else:
        bottom, top = _low(LOW_TOP, w20), _high(max(feet, HIGH_FLOOR), _curve(intensity))
        share = min((feet - LOW_TOP) / (HIGH_FLOOR - LOW_TOP), 1.0)
        length, sigma = (_between(a, b, share) for a, b in zip(bottom, top, strict=True))
    across = FOOT / TRANSVERSE_FACTOR[spec]
    return Scales((FOOT * length[0], across * length[1], across * length[2]), sigma)


def _low(feet: float, w20: float) -> Scales:
    """Return the 8785C lengths in ft and sigmas in m/s below 1000 ft."""
    bracket = 0.177 + 0.000823 * feet
    horizontal, vertical = 0.1 * w20 / bracket**0.4, 0.1 * w20
    return Scales((feet / bracket**1.2, feet / bracket**1.2, feet), (horizontal, horizontal, vertical))


def _high(feet: float, curve: tuple[float, ...]) -> Scales:
    """Return the 8785C lengths in ft and sigmas in m/s above 2000 ft."""
    sigma = FOOT * float(np.interp(feet, _ALTITUDES, curve))
    return Scales((HIGH_LENGTH, HIGH_LENGTH, HIGH_LENGTH), (sigma, sigma, sigma))


def _between(a: Triple, b: Triple, share: float) -> Triple:
    u, v, w = ((1.0 - share) * low + share * high for low, high in zip(a, b, strict=True))
    return u, v, w


def _curve(intensity: str | float) -> tuple[float, ...]:
    if not isinstance(intensity, str) and intensity > 0.0:
        raise InputError(
            f"given W20 = {intensity:g} m/s above {LOW_TOP * FOOT:g} m; a number works below that altitude only, "
            f"above it give one of: {', '.join(_EXCEEDANCE)}",
            key="intensity",
        )
    return _EXCEEDANCE[intensity if isinstance(intensity, str) else "none"]
