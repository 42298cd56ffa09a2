"""Requirements on a design before the search."""

from dataclasses import dataclass, field
from math import isfinite

from plant.errors import InputError
from plant.quadrotor.sensors import SensorSpec


@dataclass(frozen=True)
class DesignRequirements:
    """Limits that every loop keeps while its load rejection is maximized.

    Attributes:
        ms: Largest peak of the sensitivity. 1.7, with 1.5 for mt, leaves at least 39 deg of phase, 7.7 dB of gain upwards and
            9.5 dB downwards (an integrating loop on an integrating plant has a margin downwards too).
        mt: Largest peak of the complementary sensitivity.
        damping: Largest damping ratio of the PD part, so that the loop answers its reference as fast as it rejects
            disturbances; the hybrid's surface slope stays below its gain, which is the same for real poles.
        speed: Power in k_i kp^speed, which is made large; 0 looks at slow disturbances alone, 1.5 weighs both as powers
            of bandwidth, wc^3 and wc^2.
        noise: RMS of the command that sensor noise causes, as a share of what the axis can do at hover.
        attitude_step: Largest error at once that a loop answers without asking for more than the axis can do [rad]; as
            feedback on the error it bounds kp.
        position_step: The same of position [m].
        power_share: Contribution of the power-rate term to the hybrid's largest equivalent gain, as a share of it; 0 is a
            linear law.
        sensors: The sensor noise.
    """

    ms: float = 1.7
    mt: float = 1.5
    damping: float = 1.0
    speed: float = 1.5
    noise: float = 0.02
    attitude_step: float = 0.35
    position_step: float = 1.0
    power_share: float = 0.3
    sensors: SensorSpec = field(default_factory=SensorSpec)

    def __post_init__(self) -> None:
        least = {"ms": 1.0, "mt": 1.0, "damping": 0.0, "noise": 0.0, "attitude_step": 0.0, "position_step": 0.0}
        for name, bound in least.items():
            value = getattr(self, name)
            if not (isfinite(value) and value > bound):
                raise InputError(f"given {value}; must be finite and above {bound:g}", key=name)
        if not (isfinite(self.speed) and self.speed >= 0.0):
            raise InputError(f"given {self.speed}; must be finite and not negative", key="speed")
        if not 0.0 <= self.power_share < 1.0:
            raise InputError(f"given {self.power_share}; allowed: 0 up to below 1", key="power_share")

    def step(self, loop: str) -> float:
        """Return the largest error of the loop "attitude" [rad] or "position" [m]."""
        return self.attitude_step if loop == "attitude" else self.position_step

    def noises(self, loop: str) -> tuple[float, float]:
        """Return the RMS noise of the loop's measured value and rate."""
        sensors = self.sensors
        return (sensors.attitude, sensors.rate) if loop == "attitude" else (sensors.position, sensors.velocity)
