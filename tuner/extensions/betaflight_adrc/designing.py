"""Tunes by margin: for a gain margin at every throttle and a noise, the wc and wo that reject slow disturbances best.

A larger wc at a fixed ratio wo/wc raises stiffness, bandwidth and noise, and lowers the margins: bisection finds the largest one
within the limits, and of several ratios the stiffest loop is taken. Margin, bandwidth and noise of these tunes are the front.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import cache

from plant.errors import InputError
from tuner.extensions.betaflight_adrc.document import DesignRow
from tuner.extensions.betaflight_adrc.linear_loop import Margins, Sampling, margins, scaled
from tuner.extensions.betaflight_adrc.ringing import largest_gain, noise, stiffness
from tuner.extensions.betaflight_adrc.settings import SETTINGS, Tune
from tuner.extensions.betaflight_adrc.vehicle_plants import VehicleAxis, VehiclePlants

RATIOS = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0)
"""Values of wo/wc, those of published tunes."""
MARGINS = (1.25, 1.5, 2.0, 2.5, 3.0, 4.0)
"""Gain margins of the front."""
MIN_PHASE = 0.5
"""Smallest phase margin of a tune [rad]."""
MAX_MARGIN, MAX_NOISE = 10.0, 20.0
DEFAULT_NOISE = 1.0
"""Largest noise of a design over that of the present tune."""


def design_front(
    tune: Tune,
    craft: VehiclePlants,
    sampling: Sampling,
    growth: float,
    packs: Sequence[float],
    wanted: float,
    max_noise: float = DEFAULT_NOISE,
) -> list[DesignRow]:
    """Return the stiffest tune of each axis by gain margin; raises InputError for a margin that no tune keeps.

    Args:
        tune: Settings.
        craft: Plants of the craft.
        sampling: Rates and filters.
        growth: Exponent of the acceleration gain over the collective.
        packs: Voltages of the packs, over that of the plants.
        wanted: Gain margin whose tunes are wanted.
        max_noise: Largest noise of the output over that of the tune.
    """
    if not 1.0 < wanted <= MAX_MARGIN:
        raise InputError(f"given {wanted:g}; give a gain margin above 1, at most {MAX_MARGIN:g}", key="--design")
    if not 0.1 <= max_noise <= MAX_NOISE:
        raise InputError(f"given {max_noise:g}; give a factor from 0.1 to {MAX_NOISE:g}", key="--noise")
    factor = largest_gain(tune, growth, packs)
    rows = [
        row
        for axis, entry in craft.axes.items()
        for row in _front(tune, axis, entry, sampling, factor, wanted, max_noise)
    ]
    ratios = f"with wo/wc from {RATIOS[0]:g} to {RATIOS[-1]:g}"
    for axis in craft.axes:
        satisfied = [row.wanted for row in rows if row.axis == axis]
        if wanted not in satisfied:
            message = f"given {wanted:g}; {axis} keeps {max(satisfied, default=1.0):g} {ratios}"
            raise InputError(f"{message}: give less, or another b0 or filter by --gain", key="--design")
    return rows


def designed_settings(rows: Sequence[DesignRow], wanted: float) -> dict[str, str]:
    """Return the settings of the tunes with a gain margin."""
    values: Mapping[str, float] = {
        f"adrc_{name}_{row.axis}": value
        for row in rows
        if row.wanted == wanted
        for name, value in (("wc", row.wc), ("wo", row.wo))
    }
    return {name: SETTINGS[name].text(value) for name, value in values.items()}


def _front(
    tune: Tune, axis: str, entry: VehicleAxis, sampling: Sampling, factor: float, wanted: float, max_noise: float
) -> Iterator[DesignRow]:
    """Yield the stiffest tune for each gain margin."""
    fastest = scaled(entry.plant, factor)
    stiff, loud = stiffness(tune, axis, entry.plant, sampling, 1.0), noise(tune, axis, sampling, 1.0)

    @cache
    def evaluate(wc: int, ratio: float) -> tuple[Tune, Margins, float]:
        numbers = {f"adrc_wc_{axis}": float(wc), f"adrc_wo_{axis}": SETTINGS[f"adrc_wo_{axis}"].nearest(ratio * wc)}
        tried = tune.with_numbers(numbers)
        return tried, margins(tried, axis, fastest, sampling), noise(tried, axis, sampling, 1.0) / loud

    def keeps(wc: int, ratio: float, gain: float) -> bool:
        _, reached, noisy = evaluate(wc, ratio)
        return reached.gain >= gain and not reached.phase < MIN_PHASE and noisy <= max_noise

    for gain in sorted({*MARGINS, wanted}):
        candidates: list[tuple[Tune, Margins, float]] = []
        for ratio in RATIOS:
            low, high = int(SETTINGS[f"adrc_wc_{axis}"].low), int(SETTINGS[f"adrc_wo_{axis}"].high / RATIOS[-1])
            if not keeps(low, ratio, gain):
                continue
            while high - low > 1:
                middle = (low + high) // 2
                low, high = (middle, high) if keeps(middle, ratio, gain) else (low, middle)
            candidates.append(evaluate(low, ratio))
        if candidates:
            best, reached, noisy = max(
                candidates, key=lambda each: stiffness(each[0], axis, entry.plant, sampling, 1.0)
            )
            yield DesignRow(
                axis=axis,
                wanted=gain,
                wc=best.of("wc", axis),
                wo=best.of("wo", axis),
                gain_margin=reached.gain,
                ring=reached.ring,
                phase_margin=reached.phase,
                bandwidth=margins(best, axis, entry.plant, sampling).crossover,
                stiffness=stiffness(best, axis, entry.plant, sampling, 1.0) / stiff,
                noise=noisy,
            )
