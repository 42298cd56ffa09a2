"""Lines of the rotors in the gyro of a log.

They stand at 1, 2 and 3 times the speed of the rotors.

    S(o) = mean over calm windows of P(f) f_w/r^4,    o = f/f_w,    f_w = r f_hover
    a = sqrt(A/2)/|L|,    A = integral of S less its floor over the line

P is the spectrum of roll and pitch rate, r the speed of the rotors over that of hover, from the commands, and A the power that
the lines of four rotors have about an axis at hover: each adds a^2/2. The true speed may differ from the model's by one factor,
which follows from the frequency of the first line. L is the gyro's low-pass, known by its delay only.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plant.laws.filters import PI
from plant.quadrotor.airframes.rules import hover_speed
from plant.quadrotor.gyro import HARMONICS, passed
from tuner.extensions.identification.identify import Identified
from tuner.extensions.logs.flight_log import FlightLog
from tuner.extensions.vehicle_fit.parameters import PhysicalParameters, low_pass_delay
from tuner.extensions.vehicle_fit.random_effects import QUANTILE

Array = NDArray[np.float64]

WINDOW = 0.25
"""Length of a window [s]; in longer ones the speed of the rotors moves more than a bin."""
SPEEDS = (0.7, 1.45)
"""Range of the true hover speed over the model's."""
NYQUIST = 2.6
"""Least sampling rate over the frequency of a line: half of it shows all that the line fills."""
FILLED = {1: (0.8, 1.2), 2: (1.6, 2.4), 3: (2.6, 3.4)}
"""Orders over the first line's that each line fills."""
FLANKS = {1: ((0.72, 0.8), (1.45, 1.55)), 2: ((1.45, 1.55), (2.45, 2.55)), 3: ((2.45, 2.55), (3.45, 3.55))}
"""Those on both sides of it that tell its floor."""
CALM_SHARE = 0.4
"""Share of the windows that count: those with the steadiest rotors."""
MIN_WINDOWS = 8
"""Fewest windows that count."""
CLEAR = 3.0
"""Least height of the first line over its floor."""
ORDERS = np.arange(0.45, 5.8, 0.01)


class RotorLine(NamedTuple):
    """A line of the rotors.

    Attributes:
        harmonic: Its frequency over that of the rotors.
        frequency: At hover [Hz].
        logged: Amplitude of a rotor at hover as the log has it [rad/s].
        amplitude: The same before the gyro's low-pass [rad/s].
        deviation: Relative standard deviation of the latter.
    """

    harmonic: int
    frequency: float
    logged: float
    amplitude: float
    deviation: float


def rotor_lines(identified: Identified) -> tuple[RotorLine, ...]:
    """Return the lines that stand clear of their floor."""
    numbers = identified.space.numbers(identified.fit.estimate)
    hover = hover_speed(identified.airframe.vehicle) / (2.0 * PI)
    weight = 0.25 * identified.airframe.vehicle.mass * identified.airframe.vehicle.gravity
    windows = [each for log in identified.logs for each in _order_spectra(log, numbers, weight, hover)]
    calmest = sorted(windows, key=lambda window: window[0])[: max(round(CALM_SHARE * len(windows)), MIN_WINDOWS)]
    if len(calmest) < MIN_WINDOWS:
        return ()
    spectra = np.array([spectrum for _, spectrum in calmest])
    rate = min(log.rate for log in identified.logs)
    first = _first_order(spectra.mean(axis=0), rate / (NYQUIST * hover))
    if first is None:
        return ()
    at = identified.space.names.index("gyro_delay")
    deviation = float(np.sqrt(identified.covariance[at, at]))
    lines = [
        _line(spectra, n, first, hover, low_pass_delay(numbers.gyro_delay), deviation)
        for n in range(1, HARMONICS + 1)
        if rate > NYQUIST * n * first * hover
    ]
    return tuple(line for line in lines if line is not None)


def _order_spectra(
    log: FlightLog, numbers: PhysicalParameters, weight: float, hover: float
) -> Iterator[tuple[float, Array]]:
    """Yield spread of speeds and spectrum of each window.

    The spread is relative; the spectrum is over `ORDERS`, at hover speed.
    """
    for stretch in log.stretches():
        count = round(WINDOW * stretch.rate)
        ratio = _speed_ratio(stretch, numbers, weight)
        taper = np.hanning(count)
        for begin in range(0, len(stretch.time) - count + 1, max(count // 2, 1)):
            part = slice(begin, begin + count)
            rates = stretch.gyro[part, :2] - stretch.gyro[part, :2].mean(axis=0)
            power = np.abs(np.fft.rfft(rates * taper[:, None], axis=0)) ** 2
            density = 2.0 * power.mean(axis=1) / (stretch.rate * np.sum(taper**2))
            r = float(ratio[part].mean())
            turning = r * hover
            frequency = np.fft.rfftfreq(count, stretch.period)
            spectrum = np.interp(ORDERS * turning, frequency, density, right=np.nan) * turning / r**4
            yield float(ratio[part].std()) / r, spectrum


def _speed_ratio(log: FlightLog, numbers: PhysicalParameters, weight: float) -> Array:
    """Return rotor speeds (n, 4) over that of hover, from the commands."""
    thrust = np.maximum(np.polyval(numbers.curve[::-1], log.command), 0.0)
    wanted = np.sqrt(thrust / weight)
    share = -np.expm1(-log.period / (0.5 * (numbers.lag_up + numbers.lag_down)))
    speed = wanted.copy()
    for k in range(1, len(speed)):
        speed[k] = speed[k - 1] + share * (wanted[k] - speed[k - 1])
    return np.maximum(speed, 0.1)


def _first_order(spectrum: Array, highest: float) -> float | None:
    """Return the order of the first line, None where none is clear; highest: that the sampling shows."""
    orders = ORDERS[(ORDERS >= SPEEDS[0]) & (ORDERS <= min(SPEEDS[1], highest))]
    if len(orders) == 0:
        return None
    heights = [np.interp(order, ORDERS, spectrum / _floor(spectrum, 1, order)) for order in orders.tolist()]
    best = int(np.argmax(heights))
    return float(orders[best]) if heights[best] > CLEAR and 0 < best < len(orders) - 1 else None


def _floor(spectrum: Array, harmonic: int, order: float) -> Array:
    """Return the floor over `ORDERS` below a line; order: of the first line.

    It is straight in the logarithms of both, through both flanks.
    """
    sides = [(ORDERS >= low * order) & (ORDERS <= high * order) for low, high in FLANKS[harmonic]]
    below, above = (float(np.median(spectrum[side])) for side in sides)
    # Sampling may hide the upper flank.
    levels = np.log([below, above if above > 0.0 else below])
    places = np.log([order * np.sqrt(low * high) for low, high in FLANKS[harmonic]])
    return np.exp(levels[0] + (levels[1] - levels[0]) / (places[1] - places[0]) * (np.log(ORDERS) - places[0]))


def _line(
    spectra: Array, harmonic: int, order: float, hover: float, cutoff: float, deviation: float
) -> RotorLine | None:
    """Return a line, None where it is not clear.

    Args:
        spectra: Spectra of the windows (n, orders).
        harmonic: Frequency over that of the rotors.
        order: Order of the first line.
        hover: Frequency of the rotors at hover by the model [Hz].
        cutoff: Cutoff of the gyro's low-pass [Hz].
        deviation: Relative standard deviation of the cut-off.
    """
    frequency, (low, high) = harmonic * order * hover, FILLED[harmonic]
    inside = (ORDERS >= low * order) & (ORDERS <= high * order)
    floor = _floor(spectra.mean(axis=0), harmonic, order)
    powers = np.nansum((spectra - floor)[:, inside], axis=1) * (ORDERS[1] - ORDERS[0])
    # Neighbors share half of their samples.
    power, error = float(np.mean(powers)), float(np.std(powers) / np.sqrt(0.5 * len(powers)))
    if power <= QUANTILE * error:
        return None
    share = passed(frequency / cutoff)
    of_cutoff = 2.0 * (1.0 - share**2) * deviation
    logged = float(np.sqrt(0.5 * power))
    return RotorLine(harmonic, frequency, logged, logged / share, float(np.hypot(0.5 * error / power, of_cutoff)))
