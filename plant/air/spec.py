"""Description of the air in a study: one frozen value, checked once, from which every scenario is drawn."""

from dataclasses import dataclass

from plant.air import checks
from plant.air.gust import Gust
from plant.air.injection import Injection
from plant.air.intensity import HIGH_TOP, WIND_20, scales, wind_at_20_feet
from plant.air.mean_wind import ROUGHNESS, effective_airspeed, mean_wind_speed
from plant.air.turbulence_field import SPECS, TurbulenceField
from plant.air.units import FOOT
from plant.air.window import EDGE
from plant.errors import InputError


@dataclass(frozen=True)
class AirSpec:
    """The air of one study; raises InputError naming the field where a value cannot be used.

    spec: whose length convention and formulas, "8785C" or "1797". Both describe the same process and give the same
        bits; the lengths they report for v and w differ by 2.
    intensity: "none", "light", "moderate", "severe", or a number, W20 in m/s (below 1000 ft only).
    altitude: above ground [m], of the turbulence model; it does not follow the vehicle.
    vehicle_speed: over ground along the mean wind [m/s], negative into the wind; it sets the airspeed only.
    minimum_airspeed: floor of the airspeed [m/s], see `plant.air.mean_wind`.
    wind_direction_deg: where the mean wind blows TO, counter-clockwise from East (world x); None: uniform, drawn per
        scenario.
    mean_wind: whether the mean wind itself blows on the vehicle; it sets the airspeed of the turbulence either way.
    angular_rates: whether gust rates p, q, r are sampled. Off by default: at the span of a quadrotor they are
        extrapolated and p is unphysically large (1.4 rad/s RMS at moderate).
    span: rotor to rotor [m], of the gust rates only; the default is that of an AscTec Hummingbird.
    roughness: category "A", "B" (2.0 ft) or "C" (0.15 ft) of the mean wind profile.
    window: (start, end) [s] of turbulence and injected noise, None for the whole run. It gates neither the mean wind,
        nor the gust, nor a bias.
    gust, injection: further disturbances, or None.
    """

    spec: str = "8785C"
    intensity: str | float = "light"
    altitude: float = 10.0
    vehicle_speed: float = 0.0
    minimum_airspeed: float = 1.5
    wind_direction_deg: float | None = None
    mean_wind: bool = True
    angular_rates: bool = False
    span: float = 0.342
    roughness: str = "C"
    window: tuple[float, float] | None = None
    gust: Gust | None = None
    injection: Injection | None = None

    def __post_init__(self) -> None:
        checks.name(self.spec, "spec", "turbulence specification", SPECS)
        checks.name(self.roughness, "roughness", "roughness category", tuple(ROUGHNESS))
        if isinstance(self.intensity, str):
            checks.name(self.intensity, "intensity", "intensity", tuple(WIND_20))
        else:
            checks.number(self.intensity, "intensity", 0.0)
        checks.number(self.altitude, "altitude", 0.0, HIGH_TOP * FOOT, above=True)
        checks.number(self.vehicle_speed, "vehicle_speed")
        checks.number(self.minimum_airspeed, "minimum_airspeed", 0.0, above=True)
        checks.number(self.span, "span", 0.0, above=True)
        if self.wind_direction_deg is not None:
            checks.number(self.wind_direction_deg, "wind_direction_deg")
        checks.switch(self.mean_wind, "mean_wind")
        checks.switch(self.angular_rates, "angular_rates")
        if self.window is not None:
            object.__setattr__(self, "window", _window(self.window))
        scales(self.spec, self.intensity, self.altitude)

    @property
    def wind_speed(self) -> float:
        """Mean wind at the altitude [m/s], whether or not it blows on the vehicle."""
        return mean_wind_speed(wind_at_20_feet(self.intensity), self.altitude, self.roughness)

    @property
    def only_wind(self) -> bool:
        """Whether it has neither gust rates nor injections."""
        return not self.angular_rates and self.injection is None

    @property
    def field(self) -> TurbulenceField:
        """The turbulence that the vehicle meets: airspeed, lengths, intensities."""
        airspeed = effective_airspeed(self.vehicle_speed, self.wind_speed, self.minimum_airspeed)
        length, sigma = scales(self.spec, self.intensity, self.altitude)
        return TurbulenceField(self.spec, airspeed, length, sigma, self.span)


def _window(value: object) -> tuple[float, float]:
    start, end = checks.numbers(value, "window", 2, 0.0)
    if end - start < 2.0 * EDGE:
        allowed = f"give (start, end) with end at least {2.0 * EDGE:g} s after start, or leave it out"
        raise InputError(f"given {value!r}; {allowed}", key="window")
    return start, end
