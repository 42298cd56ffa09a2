"""Frequency responses of the loops for figures, at the amplitudes that their terms are closed for."""

from dataclasses import dataclass

import numpy as np

from objectives.margins.margins import MarginModel
from objectives.margins.plant_margins import PlantMargins
from objectives.margins.results import Margins
from tuner.analysis.margins.readings import Loops

Array = np.ndarray

# Frequencies of a curve, from so many rad/s up to Nyquist; of a plant, from a share of that or of its slowest crossover.
POINTS, LOWEST, LOWEST_SHARE, LOWEST_OF_CROSSOVER = 1200, 0.05, 1e-4, 0.1
# Frequencies at which loops are compared [rad/s]; of a plant, as shares of Nyquist.
TRIED, TRIED_SHARES = np.array([0.3, 2.0, 11.0, 60.0]), np.array([4e-4, 2.5e-3, 0.014, 0.076])


@dataclass(frozen=True)
class Curves:
    """Loop transfer function of one channel.

    frequency (f,) [rad/s]; loop (cases, f) complex; labels (cases,): the amplitudes in words, one empty text for a loop that
    depends on none.
    """

    channel: str
    frequency: Array
    loop: Array
    labels: tuple[str, ...]

    @property
    def gain(self) -> Array:
        """Gain [dB]."""
        return 20.0 * np.log10(np.maximum(np.abs(self.loop), 1e-12))

    @property
    def phase(self) -> Array:
        """Phase [deg], unwrapped, in (-360, 0] where the gain falls through 1 for the last time."""
        unwrapped = np.degrees(np.unwrap(np.angle(self.loop), axis=-1))
        above = np.abs(self.loop) > 1.0
        last = np.where(above.any(axis=-1), above.shape[-1] - 1 - np.argmax(above[:, ::-1], axis=-1), 0)
        turns = np.ceil(unwrapped[np.arange(len(last)), last] / 360.0)
        return unwrapped - 360.0 * turns[:, None]


def frequency_grid(model: MarginModel | PlantMargins, margins: Margins, points: int = POINTS) -> Array:
    """Return the frequencies (points,) [rad/s] at which loops with these margins are drawn, up to Nyquist."""
    nyquist = np.pi / model.period
    if not isinstance(model, PlantMargins):
        return np.geomspace(LOWEST, nyquist, points)
    crossover = margins.crossover.value[np.isfinite(margins.crossover.value) & (margins.crossover.value > 0.0)]
    slowest = LOWEST_OF_CROSSOVER * float(crossover.min(initial=nyquist))
    return np.geomspace(min(LOWEST_SHARE * nyquist, slowest), nyquist, points)


def curves_of(subject: Loops, channel: str) -> Curves:
    """Return the curves of a channel."""
    cases = subject.model.cases if subject.swept(channel) else subject.model.cases[:1]
    w = frequency_grid(subject.model, subject.margins)
    loops = [subject.model.loop(subject.row, channel, case, w).loop for case in cases]
    labels = tuple(case.label for case in cases) if len(cases) > 1 else ("",)
    return Curves(channel, w, np.array(loops), labels)


def groups(subject: Loops) -> tuple[tuple[str, ...], ...]:
    """Return the channels with a loop, those whose loops do not differ together."""
    found: dict[tuple[float, ...], list[str]] = {}
    tried = TRIED_SHARES * np.pi / subject.model.period if _of_a_plant(subject) else TRIED
    for channel in subject.looped:
        t = subject.model.loop(subject.row, channel, subject.model.cases[-1], tried).t
        found.setdefault(tuple(np.round([*t.real, *t.imag], 6).tolist()), []).append(channel)
    return tuple(tuple(alike) for alike in found.values())


def _of_a_plant(subject: Loops) -> bool:
    return isinstance(subject.model, PlantMargins)
