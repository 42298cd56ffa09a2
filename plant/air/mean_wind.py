"""Mean wind by altitude, and the airspeed at which turbulence is met.

    W(h) = W20 ln(h / z0) / ln(20 ft / z0),    3 ft < h < 1000 ft; outside, the value at the nearer end

Roughness z0 by flight phase category: C (near the ground: approach, landing) 0.15 ft, A and B 2.0 ft.
Source: MIL-F-8785C (1980), 3.7.3.

The eddies are frozen into the mean wind (Taylor), so a vehicle meets them at its speed through the air, not over
ground: a hovering vehicle sees the field drift past at W(h). Where that tends to zero the correlation times L / V tend
to infinity and the turbulence would freeze into an offset; a floor V_min keeps them finite. The airspeed stays frozen
during a run: constant times keep the sampling exact and the scenarios equal for all candidates.
"""

from math import log

from plant.air.units import FOOT

ROUGHNESS = {"A": 2.0 * FOOT, "B": 2.0 * FOOT, "C": 0.15 * FOOT}  # z0, m
_LOWEST, _HIGHEST, _REFERENCE = 3.0 * FOOT, 1000.0 * FOOT, 20.0 * FOOT


def mean_wind_speed(wind_20: float, altitude: float, roughness: str) -> float:
    """Return the mean wind [m/s] at an altitude [m] above ground for W20 [m/s] and a roughness category."""
    z0 = ROUGHNESS[roughness]
    height = min(max(altitude, _LOWEST), _HIGHEST)
    return wind_20 * log(height / z0) / log(_REFERENCE / z0)


def effective_airspeed(vehicle_speed: float, mean_wind: float, minimum: float) -> float:
    """Return max(|vehicle_speed - mean_wind|, minimum) [m/s]; vehicle speed along the wind, positive downwind."""
    return max(abs(vehicle_speed - mean_wind), minimum)
