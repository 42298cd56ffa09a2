"""Modes of small matrices against LAPACK and solved systems: random ones, defective ones, idle states."""

import numpy as np
import pytest

from objectives.margins.frequency import modes_of
from tests.objectives.margins.designs import model_of, random_gains, realisation

EVERY = (0, 1)


def random_loops(n, states, seed):
    """Matrices (n, b, b) with poles about the unit circle, inputs (n, b, 2) and outputs (n, 2, b)."""
    draw = np.random.default_rng(seed)
    a = draw.standard_normal((n, states, states)) * 0.4 / np.sqrt(states) + np.diag(np.linspace(0.2, 0.99, states))
    return a, draw.standard_normal((n, states, 2)), draw.standard_normal((n, 2, states))


def solved(a, b, c, z):
    """Responses (n, f, 2, 2) at points z (f,) by solving a system for each."""
    pencil = z[None, :, None, None] * np.eye(a.shape[-1]) - a[:, None]
    return c[:, None] @ np.linalg.solve(pencil, b[:, None].astype(complex))


CIRCLE = np.exp(1j * np.linspace(0.01, 3.1, 25))


@pytest.mark.parametrize("states", [1, 2, 3, 6, 14, 41])
def test_modes_give_the_response_and_the_poles_of_lapack(states):
    loops = random_loops(40, states, states)
    modes = modes_of(*loops)
    np.testing.assert_allclose(modes.size, np.abs(np.linalg.eigvals(loops[0])).max(axis=-1), rtol=1e-9)
    found = modes.response(np.broadcast_to(CIRCLE, (40, 25)), EVERY, EVERY)
    wanted = solved(*loops, CIRCLE)
    assert np.abs(found - wanted).max(axis=None) < 1e-9 * np.abs(wanted).max(axis=None)


def test_conjugate_poles_and_what_belongs_to_them_are_conjugate_to_the_last_bit():
    modes = modes_of(*random_loops(60, 9, 1))
    pairs = np.argwhere(modes.poles.imag > 0.0)
    assert len(pairs) > 60
    for row, k in pairs:
        assert modes.poles[row, k + 1] == modes.poles[row, k].conjugate()
        np.testing.assert_array_equal(modes.shown[row, :, k + 1], modes.shown[row, :, k].conjugate())
        np.testing.assert_array_equal(modes.driven[row, k + 1], modes.driven[row, k].conjugate())


def test_a_matrix_has_its_bits_whatever_the_others_are():
    loops = random_loops(20, 7, 2)
    whole = modes_of(*loops)
    for i in range(20):
        alone = modes_of(*[part[i : i + 1] for part in loops])
        for name in ("poles", "shown", "driven", "size"):
            np.testing.assert_array_equal(getattr(alone, name)[0], getattr(whole, name)[i], err_msg=name)


def test_beyond_a_radius_there_are_poles_and_nothing_else():
    loops = random_loops(60, 7, 3)
    whole, within = modes_of(*loops), modes_of(*loops, radius=1.0)
    stable = whole.size < 1.0
    assert 10 < stable.sum() < 50
    np.testing.assert_array_equal(within.poles, whole.poles)
    for name in ("shown", "driven"):
        np.testing.assert_array_equal(getattr(within, name)[stable], getattr(whole, name)[stable], err_msg=name)
        assert not getattr(within, name)[~stable].any()


@pytest.mark.parametrize("pole", [0.0, 0.9])
@pytest.mark.parametrize("length", [2, 3])
def test_a_chain_of_equal_poles_keeps_its_response(pole, length):
    """All poles in one place and one eigenvector: the entries are moved by 1e-13, the response by little more."""
    a = (pole * np.eye(length) + np.eye(length, k=1))[None]
    b, c = np.eye(length)[None, :, -2:], np.eye(length)[None, :2]
    found = modes_of(a, b, c).response(CIRCLE[None], EVERY, EVERY)
    wanted = solved(a, b, c, CIRCLE)
    assert np.abs(found - wanted).max(axis=None) < 1e-6 * np.abs(wanted).max(axis=None)


def test_a_matrix_of_zeros_and_one_already_triangular_are_split():
    diagonal = np.diag([0.5, -0.25, 0.0])
    for a in (np.zeros((3, 3)), diagonal, np.triu(np.ones((3, 3)), 1) + diagonal):
        modes = modes_of(a[None], np.eye(3)[None, :, :2], np.eye(3)[None, :2])
        np.testing.assert_allclose(np.sort(modes.poles[0].real), np.sort(np.diag(a)), atol=1e-12)


@pytest.mark.parametrize("row", range(4, 10))
def test_a_long_delay_line_in_a_loop_hides_no_pole_outside_the_circle(row):
    """Numbers of 1e-150 that forty delays leave stop the QR: its unfinished diagonal once passed for poles, all inside."""
    a = realisation(model_of("smith", "smith"), random_gains("smith", "smith", 160, 1)[row], "yaw").a
    modes = modes_of(a[None], np.ones((1, len(a), 1)), np.ones((1, 1, len(a))))
    assert modes.size[0] == pytest.approx(np.abs(np.linalg.eigvals(a)).max(axis=0), rel=1e-9)
    assert not modes.stable[0]
