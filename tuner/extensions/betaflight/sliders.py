"""Sliders of simplified tuning: the gains and cut-offs that `simplified_tuning apply` stores.

src/main/config/simplified_tuning.c of 4.3 to 2026.12. Boards run it as GCC compiles it with -Os and -ffast-math: in float32, a
slider times 0.01 instead of over 100, and products in another order. So 30 at 120 % is 35, as boards print it, and not 36.
"""

from collections.abc import Mapping
from math import trunc

import numpy as np

from plant.errors import InputError
from plant.input_files import ReadableFile
from plant.quadrotor.cascade import ATTITUDE_AXES
from tuner.extensions.betaflight.map import NAMES, TABLE, Release
from tuner.extensions.betaflight.text import parse_integer

MAX_SLIDER = 200.0
"""Largest slider [%]."""
MAX_CUTOFF = 1000.0
"""Largest cut-off [Hz]."""
MIN_FILTER_SLIDER = 10.0
AXES = {"OFF": (), "RP": ATTITUDE_AXES[:2], "RPY": ATTITUDE_AXES}
"""Axes of each `simplified_pids_mode`."""
MODE, DEFAULT_MODE = "simplified_pids_mode", "RPY"
GAIN_SLIDERS = tuple(
    f"simplified_{name}"
    for name in (
        "master_multiplier", "pi_gain", "i_gain", "d_gain", "feedforward_gain", "pitch_d_gain", "pitch_pi_gain"
    )
)  # fmt: skip
D_MAX_SLIDER = "simplified_d_max_gain"
"""Slider of the upper D gain."""
OLD_D_MAX_SLIDER = "simplified_dmax_gain"
"""Its name before 2025.12."""
FILTER_SLIDERS = {
    "simplified_dterm_filter": {
        "dterm_lpf1_dyn_min_hz": (75, "dterm_lpf1_dyn_min_hz"),
        "dterm_lpf1_dyn_max_hz": (150, "dterm_lpf1_dyn_min_hz"),
        "dterm_lpf1_static_hz": (75, "dterm_lpf1_static_hz"),
        "dterm_lpf2_static_hz": (150, "dterm_lpf2_static_hz"),
    },
    "simplified_gyro_filter": {
        "gyro_lpf1_dyn_min_hz": (250, "gyro_lpf1_dyn_min_hz"),
        "gyro_lpf1_dyn_max_hz": (500, "gyro_lpf1_dyn_min_hz"),
        "gyro_lpf1_static_hz": (250, "gyro_lpf1_static_hz"),
        "gyro_lpf2_static_hz": (500, "gyro_lpf2_static_hz"),
    },
}
"""Switch of a filter slider -> cut-off -> its default [Hz], and the setting that is 0 where the cut-off stays."""
F = np.float32
PERCENT, ONE = F(0.01), F(1.0)


def applied_settings(values: Mapping[str, str], release: Release, file: ReadableFile) -> dict[str, str]:
    """Return the settings that `simplified_tuning apply` stores, by the release's names.

    Raises InputError naming a slider that the firmware would refuse.

    Args:
        values: settings so far, by the names of the release.
        release: release of the firmware.
        file: path of the file for the message.
    """
    return _gains(values, release, file) | _cutoffs(values, file)


def _gains(values: Mapping[str, str], release: Release, file: ReadableFile) -> dict[str, str]:
    axes = AXES.get(mode := values.get(MODE, DEFAULT_MODE).upper())
    if axes is None:
        raise InputError(f"given '{mode[:20]}'; allowed: {', '.join(AXES)}", file=file, key=MODE)
    # A release before 2025.12 has other names for both D gains.
    called = {current: old for old, current in release.renamed.items()}
    master, pi, i, d, feed, pitch_d, pitch_pi = (_slider(values, name, file) * PERCENT for name in GAIN_SLIDERS)
    d_max = _slider(values, D_MAX_SLIDER if release.current else OLD_D_MAX_SLIDER, file)
    upper_d = _upper_d if release.current else _upper_d_before
    gains: dict[str, str] = {}
    for axis in axes:
        names = NAMES[axis]
        base = {name: F(TABLE[name].usual) for name in names}
        on_d, on_pi = (pitch_d, pitch_pi) if axis == "pitch" else (ONE, ONE)
        products = {
            names.p: base[names.p] * (master * pi) * on_pi,
            names.i: base[names.i] * (master * pi * i) * on_pi,
            names.d: base[names.d] * (master * d) * on_d,
            names.d_max: upper_d(base[names.d], base[names.d_max], master * d, on_d, d_max),
            names.f: base[names.f] * (master * feed) * on_pi,
        }
        gains |= {called.get(name, name): _stored(value, TABLE[name].high) for name, value in products.items()}
    return gains


def _upper_d(lower: F, upper: F, factor: F, pitch: F, slider: F) -> F:
    """Return the upper D gain since 2025.12, unrounded; slider: that of the upper D gain [%]."""
    product = upper * factor * pitch
    return product if upper == 0.0 else product * _fused(slider, PERCENT, lower * _fused(-slider, PERCENT, ONE) / upper)


def _upper_d_before(lower: F, upper: F, factor: F, pitch: F, slider: F) -> F:
    """Return the upper D gain before 2025.12, unrounded; slider: that of the upper D gain [%]."""
    product = lower * factor * pitch
    return product if lower == 0.0 else product * _fused(slider * PERCENT, (upper - lower) / lower, ONE)


def _fused(factor: F, other: F, term: F) -> F:
    """Return factor * other + term, rounded once; the product of two float32 is exact in double precision."""
    return F(float(factor) * float(other) + float(term))


def _stored(value: F, largest: float) -> str:
    return str(min(trunc(float(value)), int(largest)))


def _cutoffs(values: Mapping[str, str], file: ReadableFile) -> dict[str, str]:
    cutoffs: dict[str, str] = {}
    for switch, filters in FILTER_SLIDERS.items():
        if values.get(switch, "ON").upper() != "ON":
            continue
        slider = int(_slider(values, f"{switch}_multiplier", file, MIN_FILTER_SLIDER))
        for name, (usual, guard) in filters.items():
            # A low-pass that is off stays off.
            if parse_integer(values.get(guard, "1"), guard, file) != 0.0:
                cutoffs[name] = str(min(usual * slider // 100, int(MAX_CUTOFF)))
    return cutoffs


def _slider(values: Mapping[str, str], name: str, file: ReadableFile, least: float = 0.0) -> F:
    """Return a slider [%]; raises InputError where the firmware would refuse it."""
    value = parse_integer(values.get(name, "100"), name, file)
    if not least <= value <= MAX_SLIDER:
        raise InputError(f"given {value:.0f}; allowed {least:.0f} to {MAX_SLIDER:.0f}", file=file, key=name)
    return F(value)
