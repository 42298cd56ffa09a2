"""Frequency responses of the loops for figures, by amplitude."""

from dataclasses import dataclass

import numpy as np

from tuner.analysis.margins.readings import Loops

Array = np.ndarray

# Frequencies of a curve.
POINTS = 1200


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
        """Phase [deg], unwrapped, in (-360, 0] at the last crossover.

        The last crossover is the highest frequency at which the gain falls through 1.
        """
        unwrapped = np.degrees(np.unwrap(np.angle(self.loop), axis=-1))
        above = np.abs(self.loop) > 1.0
        last = np.where(above.any(axis=-1), above.shape[-1] - 1 - np.argmax(above[:, ::-1], axis=-1), 0)
        turns = np.ceil(unwrapped[np.arange(len(last)), last] / 360.0)
        return unwrapped - 360.0 * turns[:, None]


def curves_of(subject: Loops, channel: str) -> Curves:
    """Return the curves of a channel."""
    cases = subject.model.cases if subject.swept(channel) else subject.model.cases[:1]
    w = subject.model.figure_frequencies(subject.margins, POINTS)
    loops = [subject.model.loop(subject.row, channel, case, w).loop for case in cases]
    labels = tuple(case.label for case in cases) if len(cases) > 1 else ("",)
    return Curves(channel, w, np.array(loops), labels)


def groups(subject: Loops) -> tuple[tuple[str, ...], ...]:
    """Return the channels with a loop, grouped by equal loops."""
    alike_by_response: dict[tuple[float, ...], list[str]] = {}
    probed = subject.model.probe_frequencies()
    for channel in subject.looped:
        t = subject.model.loop(subject.row, channel, subject.model.cases[-1], probed).t
        alike_by_response.setdefault(tuple(np.round([*t.real, *t.imag], 6).tolist()), []).append(channel)
    return tuple(tuple(alike) for alike in alike_by_response.values())
