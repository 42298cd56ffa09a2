"""Crossings of characteristic loci whose frequencies are known: two in one cell of the grid are two."""

from typing import Any, cast

import numpy as np
import pytest

from objectives.margins.loci import NOUGHT, CharacteristicLoci, find_crossings


class Lines:
    """Eigenvalues (f, q) that move along straight lines and are real, or on the line Re T = -1/2, at given frequencies."""

    def __init__(self, level: float | None, *crossings: tuple[float, float]) -> None:
        self._level, self._crossings = level, crossings

    def values(self, w: np.ndarray) -> np.ndarray:
        """Return the eigenvalues (f, q)."""
        if self._level is None:
            return np.stack([at + 1j * (w - frequency) for frequency, at in self._crossings], axis=-1)
        return np.stack([self._level + (w - frequency) + 1j * at for frequency, at in self._crossings], axis=-1)


@pytest.mark.parametrize("level", [None, -0.5])
@pytest.mark.parametrize("apart", [0.3, 0.03, 3e-3])
def test_two_eigenvalues_that_cross_in_one_cell_are_both_found(level: float | None, apart: float) -> None:
    """One is large, which decides a margin, the other small; so it was with a gain margin of 5.4 dB that was read as 25.5."""
    truth = [(5.21, -2.13), (5.21 + apart, 0.02 if level is None else 0.9), (8.5, -0.4)]
    loci = cast(CharacteristicLoci, cast(Any, Lines(level, *truth)))
    w = np.linspace(0.0, 10.0, 21)
    found = sorted(find_crossings(loci, w, loci.values(w), level))
    assert [frequency for frequency, _ in found] == pytest.approx([frequency for frequency, _ in truth], abs=1e-9)
    place = [value.real if level is None else value.imag for _, value in found]
    assert place == pytest.approx([at for _, at in truth], abs=1e-9)


class BesideNothing(Lines):
    """Such lines beside an eigenvalue of next to nothing, which turns around 0 and is real at a frequency."""

    def __init__(self, nothing: float, *crossings: tuple[float, float]) -> None:
        super().__init__(None, *crossings)
        self._nothing = nothing

    def values(self, w: np.ndarray) -> np.ndarray:
        """Return the eigenvalues (f, q)."""
        small = 1e-3 * NOUGHT * np.exp(1j * (w - self._nothing))
        return np.concatenate([super().values(w), small[:, None]], axis=-1)


@pytest.mark.parametrize("nothing", [5.1, 5.4])
def test_an_eigenvalue_of_next_to_nothing_hides_no_crossing_in_its_cell(nothing: float) -> None:
    """It turns the sign of the product a second time within the cell, so it must not count there."""
    truth = [(5.21, -2.13), (8.5, -0.4)]
    loci = cast(CharacteristicLoci, cast(Any, BesideNothing(nothing, *truth)))
    w = np.linspace(0.0, 10.0, 21)
    found = sorted(find_crossings(loci, w, loci.values(w), None))
    assert [frequency for frequency, _ in found] == pytest.approx([frequency for frequency, _ in truth], abs=1e-9)
    assert [value.real for _, value in found] == pytest.approx([at for _, at in truth], abs=1e-9)
