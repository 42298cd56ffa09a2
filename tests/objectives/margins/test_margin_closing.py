"""Closed terms against the open loop with the terms' own answer fed back by hand."""

import numpy as np
import pytest

from objectives.margins.closing import close_terms
from objectives.margins.linearise import LinearLoops

CHANNELS, STATES = 2, 5


def open_loops(shape, terms, draw):
    """Random loops of some leading shape with terms left open; a term's own answer reaches it after others only."""
    signals = 3 * CHANNELS + terms
    a, b, c, d = (draw.standard_normal((*shape, m, n)) for m in (STATES, signals) for n in (STATES, signals))
    return LinearLoops(a, b, c, d, CHANNELS, terms)


@pytest.mark.parametrize("terms", [1, 2, 4])
@pytest.mark.parametrize(("loops_shape", "gains_shape"), [((3,), (3,)), ((3, 1), (3, 6)), ((4,), ()), ((), (2,))])
def test_a_closed_loop_answers_as_the_open_one_whose_terms_are_fed_back(terms, loops_shape, gains_shape):
    draw = np.random.default_rng(terms)
    loops, gain = open_loops(loops_shape, terms, draw), draw.uniform(0.1, 2.0, (*gains_shape, terms))
    closed = close_terms(loops, gain)
    x, u = draw.standard_normal(STATES), draw.standard_normal(loops.b.shape[-1])
    states, outputs = closed.a @ x + closed.b @ u, closed.c @ x + closed.d @ u
    fed = np.broadcast_to(u, (*outputs.shape[:-1], len(u))).copy()
    fed[..., loops.terms] += gain * outputs[..., loops.terms]
    again = (loops.c @ x) + np.einsum("...ij,...j->...i", loops.d, fed)
    np.testing.assert_allclose(again, outputs, rtol=1e-8, atol=1e-9 * np.abs(outputs).max(axis=None))
    following = (loops.a @ x) + np.einsum("...ij,...j->...i", loops.b, fed)
    np.testing.assert_allclose(following, states, rtol=1e-8, atol=1e-9 * np.abs(states).max(axis=None))


def test_a_term_that_needs_another_first_is_solved_for_in_any_order():
    """Two terms that only answer each other: the first pivot is 0."""
    loops = open_loops((1,), 2, np.random.default_rng(7))
    loops.d[:, loops.terms, loops.terms] = [[1.0, 2.0], [3.0, 0.0]]
    closed = close_terms(loops, np.array([1.0, 1.0]))
    s = np.linalg.solve(np.eye(2) - loops.d[0, loops.terms, loops.terms], loops.c[0, loops.terms])
    np.testing.assert_allclose(closed.c[0, loops.terms], s, rtol=1e-12)


def test_a_loop_has_its_bits_whatever_the_others_are():
    draw = np.random.default_rng(3)
    loops, gain = open_loops((20,), 2, draw), draw.uniform(0.1, 2.0, (20, 2))
    whole = close_terms(loops, gain)
    for i in range(20):
        alone = close_terms(loops.of(np.arange(20) == i), gain[i : i + 1])
        for name in "abcd":
            np.testing.assert_array_equal(getattr(alone, name)[0], getattr(whole, name)[i], err_msg=name)
