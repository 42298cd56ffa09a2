"""Settings of the law on the command line: ranges, defaults, and the builds that have them.

Command-line tables of pull request 15400: its documentation, and src/main/cli/settings.c at 0a71f8916. Builds are known by the
revision that a file's first line names in brackets, or by the settings that they alone have. No released firmware has the law.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf

from plant.errors import InputError, check_name, shortened
from plant.input_files import ReadableFile
from plant.laws.filters import stage_share
from plant.quadrotor.cascade import ATTITUDE_AXES
from tuner.extensions.betaflight.text import parse_integer
from tuner.extensions.betaflight_adrc.equations import (
    CRITICAL_DAMPING,
    MIN_APPLIED_HOLD,
    MIN_GROUND_LEAK,
    SCHEDULES,
    THROTTLE_CUTOFF,
    AxisConstants,
    GateConstants,
    ground_bandwidth,
    gyro_share,
    observer_bandwidth,
)

AXES = ATTITUDE_AXES
MAX_CUTOFF = 1000.0
"""Largest cut-off of a low-pass on the command line [Hz]."""


@dataclass(frozen=True)
class Setting:
    """A whole number, or one of several words, on the command line.

    Attributes:
        low, high: Range.
        default: Default of build b11.
        unit: Unit of one.
        meaning: Noun of what it sets.
        words: Words in the order of their numbers, none for a number.
    """

    low: float
    high: float
    default: float
    unit: str
    meaning: str
    words: tuple[str, ...] = ()

    def nearest(self, value: float) -> float:
        """Return the nearest whole number in the range."""
        return float(round(min(max(value, self.low), self.high)))

    def text(self, number: float) -> str:
        """Return a number as the command line prints it."""
        return self.words[round(number)] if self.words else f"{number:.0f}"


def _by_axis(name: str, defaults: Sequence[float], setting: Setting) -> dict[str, Setting]:
    return {
        f"{name}_{axis}": replace(setting, default=default, meaning=f"{setting.meaning}, {axis}")
        for axis, default in zip(AXES, defaults, strict=True)
    }


def _words(default: float, meaning: str, *words: str) -> Setting:
    return Setting(0.0, len(words) - 1.0, default, "1", meaning, words)


SCHEDULE, INHIBIT, DAMPING = "adrc_b0_law", "adrc_sat_z3_inhibit", tuple(f"adrc_zeta_{axis}" for axis in AXES)
SETTINGS: dict[str, Setting] = {
    **_by_axis("adrc_wc", (60.0, 60.0, 60.0), Setting(5.0, 300.0, 60.0, "rad/s", "bandwidth wc of the feedback")),
    **_by_axis("adrc_wo", (100.0, 100.0, 80.0), Setting(10.0, 600.0, 100.0, "rad/s", "bandwidth wo of the observer")),
    **_by_axis("adrc_b0", (2000.0,) * 3, Setting(100.0, 65535.0, 2000.0, "deg/s3", "gain b0 from output to rate''")),
    "adrc_gyro_lpf_hz": Setting(0.0, MAX_CUTOFF, 150.0, "Hz", "second-order low-pass of the gyro, 0 for none"),
    "adrc_hover_throttle": Setting(5.0, 100.0, 35.0, "%", "collective at hover"),
    SCHEDULE: _words(SCHEDULES["SQRT"], "schedule of b0 over the throttle", *SCHEDULES),
    "adrc_b0_scale_max": Setting(1.0, 50.0, 3.0, "1", "upper limit of the scale of b0"),
    "adrc_b0_scale_min": Setting(20.0, 100.0, 100.0, "%", "lower limit of the scale of b0"),
    "adrc_sigma_decay": Setting(0.0, 100.0, 3.0, "0.1/s", "leak of z3 in the air"),
    "adrc_gated_z3_decay": Setting(0.0, 2000.0, 200.0, "0.1/s", "leak of z3 on the ground"),
    "adrc_liftoff_throttle": Setting(1.0, 100.0, 40.0, "%", "collective that opens the gate"),
    "adrc_liftoff_gyro_dps": Setting(1.0, 255.0, 20.0, "deg/s", "rate that opens the gate"),
    "adrc_liftoff_hold_ms": Setting(0.0, 5000.0, 25.0, "ms", "time that the rate takes to open the gate"),
    "adrc_ground_wc": Setting(0.0, 255.0, 10.0, "rad/s", "upper limit of wc on the ground, 0 for none"),
    "adrc_wc_ramp_ms": Setting(0.0, 5000.0, 100.0, "ms", "ramp of wc after lift-off"),
    "adrc_ground_dgain": Setting(0.0, 100.0, 40.0, "0.1", "upper limit of 2 wc wo/b0 on the ground, 0 for none"),
    INHIBIT: _words(0.0, "stop of growing z3 while the mixer is saturated", "OFF", "ON"),
    **_by_axis("adrc_zeta", (100.0,) * 3, Setting(0.0, 100.0, 100.0, "%", "damping ratio of the feedback")),
    "adrc_td_hz": Setting(0.0, MAX_CUTOFF, 0.0, "Hz", "first-order low-pass of the setpoint, 0 for none"),
    "adrc_motor_tau_ms": Setting(0.0, 100.0, 0.0, "ms", "motor lag in the observer of roll and pitch, 0 for none"),
    "pidsum_limit": Setting(100.0, 1000.0, 500.0, "1", "limit of output and z3, roll and pitch"),
    "pidsum_limit_yaw": Setting(100.0, 1000.0, 400.0, "1", "limit of output and z3, yaw"),
}
GROUND = ("adrc_ground_wc", "adrc_wc_ramp_ms", "adrc_ground_dgain")
LAG = "adrc_motor_tau_ms"
EARLY = frozenset({*GROUND, *DAMPING, "adrc_b0_scale_min", INHIBIT, LAG})
"""Settings that came after build b10.1."""


@dataclass(frozen=True)
class Build:
    """A build of the firmware with the law.

    Attributes:
        name: Name among its testers.
        revisions: Beginnings of the revisions that print as this build.
        lacks: Settings of the table that it has not.
        schedule: Default schedule of b0.
        has_early_gate: Whether the applied collective opens nothing, and |z3| stops to grow on the ground only at idle.
    """

    name: str
    revisions: tuple[str, ...]
    lacks: frozenset[str]
    schedule: str = "SQRT"
    has_early_gate: bool = False

    def has(self, name: str) -> bool:
        """Return True for a setting of the build."""
        return name in SETTINGS and name not in self.lacks


BUILDS: dict[str, Build] = {
    build.name: build
    for build in (
        Build("pr-august", ("6317fe2",), EARLY | {SCHEDULE}, "QUADRATIC", has_early_gate=True),
        Build("b10.1", ("923932b",), EARLY, "QUADRATIC"),
        Build("b11", ("e6511d6",), frozenset({LAG})),
        Build("pr", ("1eabcb3", "0a71f89"), frozenset({LAG, *DAMPING})),
        Build("mp2", (), frozenset({"adrc_td_hz", *DAMPING})),
    )
}
"""Builds by name; "pr" is the line of the pull request, b11 without damping ratios; "pr-august" is its head of August 4."""
DEFAULT_BUILD = "b11"
REVISION = re.compile(r"#\s*Betaflight\s*/.*\(([0-9a-f]{7,40})\).*")
"""First line of a file, with the revision in brackets."""


def build_of(name: str) -> Build:
    """Return a build by name; raises UnknownNameError with those that are known."""
    check_name("build", name, BUILDS, key="build")
    return BUILDS[name]


def recognize_build(revision: str, names: frozenset[str]) -> Build | None:
    """Return the build of a revision or settings, None without a match."""
    for build in BUILDS.values():
        if build.revisions and revision.startswith(build.revisions):
            return build
    if LAG in names:
        return BUILDS["mp2"]
    return BUILDS["b11"] if names & set(DAMPING) else None


def read_setting(name: str, text: str, build: Build, file: ReadableFile) -> float:
    """Return a setting of the command line as a number; raises InputError naming it."""
    words = SETTINGS[name].words if name in SETTINGS else ()
    if words and text.upper() not in words:
        raise InputError(f"given {shortened(text)}; allowed: {', '.join(words)}", file=file, key=name)
    value = float(words.index(text.upper())) if words else parse_integer(text, shortened(name), file)
    try:
        check_setting(name, value, build)
    except InputError as error:
        raise error.located(file=file) from None
    return value


def check_setting(name: str, value: float, build: Build) -> None:
    """Raise InputError for a number outside its range or its build."""
    if not build.has(name):
        raise InputError(f"build {build.name} has no such setting; name the build by --build", key=shortened(name))
    setting = SETTINGS[name]
    if not (setting.low <= value <= setting.high and value == round(value)):
        raise InputError(
            f"given {value:g} {setting.unit}; give a whole number from {setting.low:g} to {setting.high:g}", key=name
        )


@dataclass(frozen=True)
class Tune:
    """The settings of a PID profile.

    Attributes:
        numbers: Every setting of `SETTINGS`, by name.
        build: Build of the firmware.
    """

    numbers: Mapping[str, float]
    build: Build = field(default=BUILDS[DEFAULT_BUILD])

    @property
    def schedule(self) -> str:
        """Schedule of b0, in the words of the command line."""
        return self.text(SCHEDULE)

    def text(self, name: str) -> str:
        """Return a setting as the command line prints it."""
        return SETTINGS[name].text(self.numbers[name])

    def of(self, name: str, axis: str) -> float:
        """Return a number of an axis, such as wc."""
        return self.numbers[f"adrc_{name}_{axis}"]

    def limit(self, axis: str) -> float:
        """Return the limit of the output of an axis."""
        return self.numbers["pidsum_limit_yaw" if axis == "yaw" else "pidsum_limit"]

    def with_numbers(self, changes: Mapping[str, float]) -> "Tune":
        """Return the tune with other numbers; raises InputError for one outside its range or its build."""
        for name, value in changes.items():
            check_setting(name, value, self.build)
        return Tune({**self.numbers, **changes}, self.build)

    def axis(self, axis: str, period: float) -> AxisConstants:
        """Return the constants of an axis at a loop period [s]."""
        wc, b0, numbers = self.of("wc", axis), self.of("b0", axis), self.numbers
        wo = observer_bandwidth(self.of("wo", axis), period)
        leak = 0.1 * numbers["adrc_sigma_decay"]
        lag = 0.0 if axis == "yaw" else 1e-3 * numbers[LAG]
        cutoff = numbers["adrc_td_hz"]
        return AxisConstants(
            wc,
            ground_bandwidth(numbers["adrc_ground_wc"], 0.1 * numbers["adrc_ground_dgain"], wc, wo, b0),
            wo,
            b0,
            gyro_share(numbers["adrc_gyro_lpf_hz"], period),
            stage_share(cutoff, period) if cutoff > 0.0 else 0.0,
            leak,
            max(0.1 * numbers["adrc_gated_z3_decay"], leak, MIN_GROUND_LEAK),
            1.0 / lag if lag > 0.0 else 0.0,
            self.limit(axis),
            0.01 * CRITICAL_DAMPING * self.of("zeta", axis),
        )

    def gate(self, period: float) -> GateConstants:
        """Return the constants of gate and schedule at a loop period [s]."""
        numbers, ramp = self.numbers, self.numbers["adrc_wc_ramp_ms"]
        hold, is_early = 0.001 * numbers["adrc_liftoff_hold_ms"], self.build.has_early_gate
        return GateConstants(
            0.01 * numbers["adrc_liftoff_throttle"],
            numbers["adrc_liftoff_gyro_dps"],
            hold,
            inf if is_early else max(MIN_APPLIED_HOLD, hold),
            float(is_early),
            1000.0 / ramp if ramp > 0.0 else 0.0,
            stage_share(THROTTLE_CUTOFF, period),
            0.01 * numbers["adrc_hover_throttle"],
            numbers[SCHEDULE],
            0.01 * numbers["adrc_b0_scale_min"],
            numbers["adrc_b0_scale_max"],
        )


def default_tune(build: Build = BUILDS[DEFAULT_BUILD]) -> Tune:
    """Return the defaults of a build; settings that it has not are switched off."""
    numbers = {name: setting.default for name, setting in SETTINGS.items()}
    numbers[SCHEDULE] = SCHEDULES[build.schedule]
    return Tune(numbers | dict.fromkeys(set(GROUND) & build.lacks, 0.0), build)
