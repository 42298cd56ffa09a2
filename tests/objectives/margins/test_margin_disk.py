"""Disk margins: published numbers, identities, and perturbations from the disk that a loop must bear."""

import numpy as np
import pytest
from scipy.optimize import minimize

from objectives.margins.disk import disk_range
from objectives.margins.multiloop import mu_upper
from objectives.margins.trim import Trim
from plant.quadrotor.nominal import ControlOptions
from plant.vectors import Vec3
from tests.objectives.margins.designs import default_gains, model_of, random_gains
from tests.objectives.margins.peak_guarantees import guaranteed_by_complementary, guaranteed_by_sensitivity

# alpha, sigma: least and largest gain, phase [deg].
PUBLISHED = {
    (0.5, 0.0): (0.6, 1.6667, 28.07),
    (0.6, 0.75): (0.6066, 2.2632, 34.23),
    (0.75, 0.0): (0.4545, 2.2, 41.11),
    (0.75, 0.5): (None, None, 41.79),
    (0.75, -0.5): (None, None, 41.79),
}


@pytest.mark.parametrize(("alpha", "sigma"), PUBLISHED)
def test_ranges_are_the_published_ones(alpha, sigma):
    found = disk_range(alpha, sigma)
    low, high, phase = PUBLISHED[alpha, sigma]
    assert np.degrees(found.phase) == pytest.approx(phase, abs=0.006)
    if low is not None:
        assert (found.low, found.high) == (pytest.approx(low, abs=6e-5), pytest.approx(high, abs=6e-5))


def test_6_decibel_and_45_degrees_stand_for_the_published_disks():
    assert 20.0 * np.log10(disk_range(0.6646).high) == pytest.approx(6.0, abs=0.0005)
    assert np.degrees(disk_range(0.8284).phase) == pytest.approx(45.0, abs=0.005)
    open_above = disk_range(1.0, 1.0)
    assert (open_above.low, open_above.high, np.degrees(open_above.phase)) == (0.5, np.inf, pytest.approx(60.0))


def test_peaks_guarantee_what_textbooks_say():
    for peak, gain, phase in ((1.4, 10.9, 41.8), (1.7, 7.7, 34.2), (2.0, 6.02, 28.96)):
        held = guaranteed_by_sensitivity(np.array(peak))
        assert (20.0 * np.log10(held.gain), np.degrees(held.phase)) == (
            pytest.approx(gain, abs=0.06),
            pytest.approx(phase, abs=0.06),
        )
    held = guaranteed_by_complementary(np.array([2.0, 0.4]))
    np.testing.assert_allclose(held.gain, [1.5, 3.5])
    np.testing.assert_allclose(np.degrees(held.phase), [28.955, 180.0], atol=1e-3)
    nothing = guaranteed_by_sensitivity(np.array(np.inf))
    assert (nothing.gain, nothing.phase) == (1.0, 0.0)


def test_margins_of_a_design_keep_what_its_peaks_and_disk_guarantee():
    model = model_of("ladrc", "hybrid", ControlOptions())
    m = model.evaluate(random_gains("ladrc", "hybrid", 40, 5))
    held = m.stable
    near = 1.0 - 1e-9
    by_s = guaranteed_by_sensitivity(m.sensitivity.value[held])
    by_t = guaranteed_by_complementary(m.complementary.value[held])
    disk = disk_range(m.disk.value[held])
    for gain, phase in (by_s, by_t, (disk.high, disk.phase)):
        assert (m.gain_up.value[held] >= near * gain).all()
        assert (m.phase.value[held] >= near * phase).all()
    assert (m.gain_down.value[held] >= near / disk.low).all()


def random_matrices(k, n, seed):
    draw = np.random.default_rng(seed)
    return draw.standard_normal((n, k, k)) + 1j * draw.standard_normal((n, k, k))


def test_mu_of_matrices_that_are_known_in_closed_form():
    """Diagonal: the largest entry; rank one u v*: sum of |u_i v_i|; a cycle: the geometric mean of its entries."""
    draw = np.random.default_rng(1)
    for k in (2, 3, 4):
        u, v = random_matrices(k, 2, k)[:, 0]
        size = np.exp(draw.uniform(-3.0, 3.0, k))
        diagonal = np.diag(u)
        rank_one = np.outer(u * size, np.conj(v) / size)
        cycle = np.roll(np.diag(u), 1, axis=1)
        wanted = [np.abs(u).max(axis=0), np.sum(np.abs(u * v), axis=0), np.prod(np.abs(u), axis=0) ** (1.0 / k)]
        np.testing.assert_allclose(mu_upper(np.array([diagonal, rank_one, cycle])), wanted, rtol=1e-6)


@pytest.mark.parametrize("k", [2, 3, 4])
def test_mu_bound_is_the_least_over_scalings_and_above_every_perturbation(k):
    m = random_matrices(k, 6, 10 + k)
    found = mu_upper(m)
    draw = np.random.default_rng(2)
    for one, bound in zip(m, found, strict=True):

        def norm(log_d, one=one):
            d = np.exp(np.append(log_d, 0.0))
            return np.linalg.norm(one * d[:, None] / d, 2)

        best = minimize(
            norm, np.zeros(k - 1), method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12, "maxiter": 4000}
        )
        # Where the largest singular value is a double one the gradient has a kink, and the descent stops a little above.
        assert best.fun * (1.0 - 1e-9) <= bound <= best.fun * (1.0 + 5e-4)
        # rho(U M) <= mu for every diagonal unitary U, with equality for the worst one where k <= 3.
        turned = np.exp(2j * np.pi * draw.uniform(size=(4000, k)))
        radius = np.abs(np.linalg.eigvals(turned[:, :, None] * one)).max(axis=-1).max(axis=0)
        assert 0.8 * bound < radius <= bound * (1.0 + 1e-9)


def test_multiloop_margin_is_the_least_of_the_loops_where_they_are_apart_and_less_where_not():
    gains = random_gains("ladrc", "ladrc", 6, 3, 0.3)
    inputs = [2, 3, 4, 5]
    apart = model_of("ladrc", "ladrc").evaluate(gains)
    np.testing.assert_allclose(apart.multiloop.value, apart.disk.value[:, inputs].min(axis=1), rtol=1e-12)
    tied = model_of("ladrc", "ladrc", trim=Trim(yaw=0.5, wind=Vec3(5.0, 3.0, 0.0))).evaluate(gains)
    least = tied.disk.value[:, inputs].min(axis=1)
    assert (tied.multiloop.value <= least * (1.0 + 1e-9)).all()
    assert (tied.multiloop.value > 0.5 * least).all()


def test_a_loop_bears_every_set_of_gains_from_its_multiloop_disk():
    """Real and complex factors in all plant inputs at once leave all poles inside; a little beyond the disk some do not."""
    model = model_of("ladrc", "ladrc", trim=Trim(wind=Vec3(6.0, 2.0, 0.0)))
    gains = default_gains("ladrc", "ladrc")
    alpha = model.evaluate(gains[None]).multiloop.value[0]
    ((_, (loops,)),) = model.open_blocks(gains)
    b, c = loops.b[0][:, loops.injected][:, 2:], loops.c[0][loops.command][2:]
    draw = np.random.default_rng(4)
    turned = np.exp(2j * np.pi * draw.uniform(size=(500, 4)))

    def largest_pole(size):
        d = size * alpha * turned
        factor = (1.0 + 0.5 * d) / (1.0 - 0.5 * d)
        return np.abs(np.linalg.eigvals(loops.a[0] + b @ ((factor - 1.0)[:, :, None] * c))).max(axis=-1)

    assert largest_pole(0.99).max(axis=0) < 1.0
    assert largest_pole(1.25).max(axis=0) > 1.0
