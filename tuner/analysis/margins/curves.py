"""Frequency responses of the loops for figures, at the amplitudes that their terms are closed for."""

from dataclasses import dataclass

import numpy as np

from tuner.analysis.margins.readings import Subject

Array = np.ndarray

# Frequencies of a curve, from so many rad/s up to Nyquist.
POINTS, LOWEST = 1200, 0.05
# Frequencies [rad/s] at which loops are compared.
TRIED = np.array([0.3, 2.0, 11.0, 60.0])


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


def curves_of(subject: Subject, channel: str) -> Curves:
    """Return the curves of a channel."""
    cases = subject.model.cases if subject.swept(channel) else subject.model.cases[:1]
    w = np.geomspace(LOWEST, np.pi / subject.model.period, POINTS)
    loops = [subject.model.loop(subject.row, channel, case, w).loop for case in cases]
    labels = tuple(case.label for case in cases) if len(cases) > 1 else ("",)
    return Curves(channel, w, np.array(loops), labels)


def groups(subject: Subject) -> tuple[tuple[str, ...], ...]:
    """Return the channels with a loop, those whose loops do not differ together."""
    found: dict[tuple[float, ...], list[str]] = {}
    for channel in subject.looped:
        t = subject.model.loop(subject.row, channel, subject.model.cases[-1], TRIED).t
        found.setdefault(tuple(np.round([*t.real, *t.imag], 6).tolist()), []).append(channel)
    return tuple(tuple(alike) for alike in found.values())
