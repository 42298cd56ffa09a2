"""Our PID as the parameters of ArduPilot Copter's cascade, and back.

Attitude and horizontal loops are P around PI, as in `autopilot.pid`. The vertical loop is P around P around a PI on the measured
acceleration: with K the acceleration that an acceleration error gives [1] and Ki that of its integral [1/s],

    a = K (a_c - a) + Ki int (a_c - a),    a_c = p (q (r - z) - z')

    (1 + K) z'' + (K p + Ki) z' + (K p q + Ki p) z + Ki p q int z = disturbance

so its poles are those of our PID with kd = (K p + Ki)/(1 + K) and so on: K adds a virtual mass. K is chosen; then
K s^3 + (1 + K)(kd s^2 + kp s + ki) = (K s + Ki)(s^2 + p s + p q), and any real root -Ki/K of the cubic will do.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import degrees, radians

import numpy as np

from plant.errors import InputError
from plant.laws.pid import Gains
from plant.quadrotor.cascade import ATTITUDE_AXES
from tuner.exchange.target import number
from tuner.extensions.ardupilot.ranges import (
    ACCEL_GAIN,
    EXPO,
    SEPARATOR,
    SHORT,
    TILT,
    YAW_FILTER,
    Dialect,
    check_arming,
)
from tuner.extensions.ardupilot.text import write_param
from tuner.extensions.autopilots.cascade import Autopilot
from tuner.extensions.autopilots.parameters import Values, range_violation
from tuner.extensions.autopilots.pid import SAME, axis_gains, held_tilt, same_feedback
from tuner.extensions.autopilots.scales import (
    ardupilot_factors,
    command_slope,
    hover_share,
    linearizing_model,
    torque_scale,
)
from tuner.gains import Controller

GRAVITY = 9.80665
# Parameter of the largest lean angle where PSC_ANGLE_MAX is 0 -> its unit in degrees; both default to 30 deg.
LEAN = {"4.6": ("ANGLE_MAX", 0.01, 3000.0), "4.7": ("ATC_ANGLE_MAX", 1.0, 30.0)}
# Terms of the position loops that ours have not.
OFF_ROLES = ("vxy_d", "vxy_ff", "vxy_flte", "vz_i", "vz_d", "vz_ff", "vz_flte", "az_d", "az_ff")
# Imaginary parts below this share of the largest root are rounding.
REAL = 1e-9
# Integral limit of the horizontal velocity loop [m/s2]: the default, and as much as 45 deg of tilt give.
HORIZONTAL_LIMIT = 10.0


@dataclass(frozen=True)
class Vertical:
    """The vertical loop: K [1], Ki [1/s]; outer q [1/s], velocity p [1/s]."""

    accel: float
    accel_i: float
    outer: float
    p: float


def vertical_loops(gains: Gains, accel: float, present: Vertical | None = None) -> tuple[Vertical, ...]:
    """Return every form of the vertical loop with K = accel: fastest first.

    present: the form on the vehicle; where it gives these gains it is the only one, else the nearest to it comes first.
    """
    if present is not None and present.accel == accel and same_feedback(vertical_gains(present, gains.t_f), gains):
        return (present,)
    if accel <= 0.0:
        return ()
    mass = 1.0 + accel
    roots = np.roots([accel, mass * gains.kd, mass * gains.kp, mass * gains.ki])
    real = sorted(float(root.real) for root in roots if abs(root.imag) <= REAL * np.max(np.abs(roots), axis=0))
    forms = []
    for root in real:
        p = mass * gains.kd / accel + root
        product = mass * gains.kp / accel + root * p
        if p > 0.0 and product >= 0.0:
            forms.append(Vertical(accel, -root * accel, product / p, p))
    if present is None or present.accel <= 0.0:
        return tuple(forms)
    return tuple(sorted(forms, key=lambda loop: abs(loop.accel_i / loop.accel - present.accel_i / present.accel)))


def vertical_gains(loop: Vertical, t_f: float) -> Gains:
    """Return our gains with the poles of a vertical loop."""
    mass = 1.0 + loop.accel
    kp = (loop.accel * loop.p * loop.outer + loop.accel_i * loop.p) / mass
    return Gains(kp, loop.accel_i * loop.p * loop.outer / mass, (loop.accel * loop.p + loop.accel_i) / mass, t_f)


@dataclass(frozen=True)
class ArduPilot(Autopilot):
    """ArduPilot Copter on an airframe."""

    version: Dialect

    def units(self, values: Values) -> dict[str, float]:
        """Return the unit of the inner P in ours [1/s]: by axis but z; values: complete."""
        slope = command_slope(self.rotors, values[EXPO])
        torques = torque_scale(self.rotors, ardupilot_factors(self.rotors), slope, "ArduPilot")
        turning = {
            axis: torque / inertia
            for axis, inertia, torque in zip(ATTITUDE_AXES, self.vehicle.inertia, torques, strict=True)
        }
        return turning | {"x": self.vehicle.gravity / GRAVITY}

    def climb(self, values: Values) -> float:
        """Return the unit of the acceleration gains in ours [1]; values: complete."""
        climb = 4.0 * command_slope(self.rotors, values[EXPO]) / self.vehicle.mass
        return self.version.acceleration * climb

    def vertical(self, values: Values) -> Vertical:
        """Return the vertical loop; values: complete."""
        scale, names = self.climb(values), self.version.named("az_p", "az_i", "z_p", "vz_p")
        accel, accel_i, outer, p = (values[name] for name in names)
        return Vertical(scale * accel, scale * accel_i, outer, p)

    def accel_share(self, model: float, share: float) -> dict[str, float]:
        """Return the acceleration P gain of a share: of hover throttle per 10 m/s2; model: MOT_THST_EXPO."""
        (name,) = self.version.named("az_p")
        return {name: 0.1 * share * hover_share(self.rotors, model) / self.version.acceleration}

    def to_parameters(
        self, controller: Controller, others: Values, present: Values | None = None, counted: bool = False
    ) -> dict[str, float]:
        """Return the parameters that our loops carry; PSC_ANGLE_MAX is missing where the vehicle's other limit is ours."""
        values = super().to_parameters(controller, others, present, counted)
        return values | self._vertical_parameters(controller, others, present)

    def _vertical_parameters(self, controller: Controller, others: Values, present: Values | None) -> dict[str, float]:
        """Return the vertical loop; of several forms the one nearest to the vehicle's, or that fits its ranges best."""
        scale, (az_p, *names) = self.climb(others), self.version.named("az_p", "z_p", "vz_p", "az_i")
        theirs = None if present is None else self.vertical(self.completed(present))
        accel = scale * others[az_p]
        candidates = [
            dict(zip(names, (loop.outer, loop.p, loop.accel_i / scale), strict=True))
            for loop in vertical_loops(axis_gains(controller, "z"), accel, theirs)
        ]
        if not candidates:
            raise InputError(
                f"kp, ki and kd of z have no form as position, velocity and acceleration loop with K = {accel:.3g}; allowed: a "
                "kd that damps more, or another --set accel_gain",
                key="z.kd",
            )
        return candidates[0] if theirs else min(candidates, key=lambda form: range_violation(self.version.table, form))

    def to_gains(self, values: Values, filters: Mapping[str, float], counted: bool = False) -> dict[str, Gains]:
        """Return our gains; see `Autopilot.to_gains`."""
        vertical = vertical_gains(self.vertical(values), filters.get("z", 0.0))
        return super().to_gains(values, filters, counted) | {"z": vertical}

    def tilt_limit(self, values: Values) -> tuple[float, str]:
        """Return the largest tilt [rad] and its parameter: PSC_ANGLE_MAX, or the lean angle where that is 0."""
        if values.get(TILT, 0.0) > 0.0:
            return radians(values[TILT]), TILT
        name, unit, usual = LEAN[self.version.firmware]
        return radians(unit * values.get(name, usual)), name

    def written_tilt(self, limit: float, present: Values | None) -> dict[str, float]:
        """Return PSC_ANGLE_MAX [deg]: unchanged where our limit [rad] follows from the vehicle's."""
        if present is not None and abs(held_tilt(self.tilt_limit(present)[0]) - limit) <= SAME * limit:
            return {TILT: present[TILT]} if TILT in present else {}
        return {TILT: degrees(limit)}

    def switched_off(self, settings: Mapping[str, str]) -> dict[str, float]:
        """Return ArduPilot's other parameters at values with which it flies our loops."""
        version, curve = self.version, linearizing_model(self.rotors)
        terms = ("D", "FF", "D_FF", "FLTE", "SMAX")
        values = {f"ATC_RAT_{short}_{term}": 0.0 for short in SHORT.values() for term in terms}
        del values[YAW_FILTER]
        for short in SHORT.values():
            values |= {f"ATC_RAT_{short}_IMAX": 1.0, f"ATC_RAT_{short}_FLTT": 50.0 if short == "YAW" else 100.0}
        values |= dict.fromkeys(version.named(*OFF_ROLES), 0.0)
        limits = (version.metre * HORIZONTAL_LIMIT, version.full_scale)
        values |= dict(zip(version.named("vxy_imax", "az_imax"), limits, strict=True))
        values |= {EXPO: curve, "MOT_THST_HOVER": hover_share(self.rotors, curve)}
        return values | self.accel_share(curve, accel_gain(settings) or 1.0)

    def chosen(self, settings: Mapping[str, str], unchanged: dict[str, float]) -> dict[str, float]:
        """Return a vehicle's unchanged parameters, with the acceleration gain of the options."""
        share = accel_gain(settings)
        return unchanged if share is None else unchanged | self.accel_share(self.completed(unchanged)[EXPO], share)

    def check(self, values: Values) -> None:
        """Refuse parameters with which a vehicle does not arm."""
        check_arming(values, self.version)

    def written(self, values: Values, settings: Mapping[str, str], comments: Sequence[str]) -> bytes:
        """Return the content of a parameter file."""
        return write_param(values, settings[SEPARATOR], comments)


def accel_gain(settings: Mapping[str, str]) -> float | None:
    """Return the option: a share of hover throttle per 10 m/s2 [1]; None for the vehicle's value."""
    return None if settings[ACCEL_GAIN] == "vehicle" else number(settings, ACCEL_GAIN, 0.2, 5.0, "1")
