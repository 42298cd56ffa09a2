"""The margins of a batch of candidates: conventions, worst cases, batches, and loops of any kind against python-control."""

from functools import cache

import control
import numpy as np
import pytest

from objectives.margins.block import read_curves
from objectives.margins.describing import DEFAULT_CASES, Case
from objectives.margins.frequency import frequency_grid, modes_of
from objectives.margins.margins import MarginModel, spread_corners
from objectives.margins.period import CHANNELS
from objectives.margins.results import QUANTITIES, decibel
from objectives.margins.trim import Trim
from plant.laws import LAWS
from plant.nominal import ControlOptions, nominal, vary
from plant.scenarios import Spread
from plant.vectors import Vec3
from tests.objectives.margins.designs import (
    HUMMINGBIRD,
    TIMING,
    H,
    cascade_of,
    default_gains,
    gains_with,
    model_of,
    random_gains,
)  # fmt: skip

NAMES = [entry.name for entry in QUANTITIES]
WIND = Trim(yaw=0.4, wind=Vec3(3.0, 1.0, 0.0))


def values(margins):
    """All quantities (quantities, n, channels)."""
    return np.array([getattr(margins, name).value for name in NAMES])


@pytest.mark.parametrize("name", LAWS)
def test_no_candidate_gives_nan_and_an_unstable_one_no_margin(name):
    model = model_of(name, name, cases=DEFAULT_CASES)
    m = model.evaluate(random_gains(name, name, 30, 1, 3.0))
    found = values(m)
    assert not np.isnan(found).any()
    assert not np.isnan([getattr(m, each).frequency for each in NAMES]).any()
    assert ((m.growth < 0.0) == m.stable).all()
    unstable = ~m.stable
    assert unstable.any() and (m.multiloop.value[unstable.any(axis=1)] == 0.0).all()
    for entry in QUANTITIES:
        if entry.name != "crossover":
            assert (getattr(m, entry.name).value[unstable] == entry.unstable).all()
    stable = m.stable
    assert (m.gain_up.value[stable] > 1.0).all() and (m.gain_down.value[stable] > 1.0).all()
    assert (m.phase.value[stable] > 0.0).all() and (m.delay.value[stable] > 0.0).all()
    assert (m.sensitivity.value[stable] >= 1.0).all() and (m.modulus[unstable] == 0.0).all()


@pytest.mark.parametrize("trim", [Trim(), WIND], ids=["hover", "wind"])
def test_a_batch_is_its_candidates_one_by_one(trim):
    model = model_of("ladrc", "hybrid", trim=trim, cases=(Case(0.0), Case(0.2)))
    gains = random_gains("ladrc", "hybrid", 4, 2)
    whole = values(model.evaluate(gains))
    single = np.concatenate([values(model.evaluate(row[None])) for row in gains], axis=1)
    np.testing.assert_allclose(whole, single, rtol=1e-8)


def test_a_long_batch_is_worked_on_in_parts_and_put_together_in_order(monkeypatch):
    model = model_of("pid", "ladrc")
    gains = random_gains("pid", "ladrc", 7, 6)
    whole = model.evaluate(gains)
    monkeypatch.setattr("objectives.margins.margins.CHUNK", 3)
    parts = model.evaluate(gains)
    np.testing.assert_allclose(values(parts), values(whole), rtol=1e-9)
    np.testing.assert_array_equal(parts.stable, whole.stable)
    np.testing.assert_allclose(parts.multiloop.value, whole.multiloop.value, rtol=1e-9)


def test_a_loop_that_mirrors_another_has_the_margins_that_it_has_by_itself():
    """Gains that are alike in x and y, roll and pitch are read off once; a difference in the last digits has both read off."""
    model = model_of("ladrc", "hybrid", cases=(Case(0.0), Case(0.2)))
    gains = default_gains("ladrc", "hybrid")[None]
    nudged = gains * (1.0 + 1e-13 * np.arange(gains.shape[1]))
    np.testing.assert_allclose(values(model.evaluate(gains)), values(model.evaluate(nudged)), rtol=1e-7)
    mirrored = values(model.evaluate(gains))
    for one, other in (("x", "y"), ("roll", "pitch")):
        np.testing.assert_array_equal(mirrored[..., CHANNELS.index(one)], mirrored[..., CHANNELS.index(other)])
    own = values(model.evaluate(gains_with("ladrc", "hybrid", roll__omega_o=20.0)))
    assert not np.allclose(own[..., CHANNELS.index("roll")], own[..., CHANNELS.index("pitch")], rtol=1e-3)
    skewed = HUMMINGBIRD._replace(inertia=HUMMINGBIRD.inertia._replace(y=1.3 * HUMMINGBIRD.inertia.y))
    apart = values(model_of("ladrc", "hybrid", vehicle=skewed).evaluate(gains))
    assert not np.allclose(apart[..., CHANNELS.index("roll")], apart[..., CHANNELS.index("pitch")], rtol=1e-3)


def test_the_worst_case_is_the_worst_of_its_cases_and_says_which():
    cases = (Case(0.0), Case(0.1), Case(1.0), Case(None))
    gains = random_gains("ladrc", "hybrid", 5, 3, 0.3)
    together = model_of("ladrc", "hybrid", cases=cases).evaluate(gains)
    apart = np.array([values(model_of("ladrc", "hybrid", cases=(case,)).evaluate(gains)) for case in cases])
    for i, entry in enumerate(QUANTITIES):
        found = getattr(together, entry.name)
        worst = apart[:, i].min(axis=0) if entry.better == "more" else apart[:, i].max(axis=0)
        np.testing.assert_allclose(found.value, worst, rtol=1e-9)
        linear = [CHANNELS.index("z")]
        assert (found.case[:, linear] == -1).all()
        swept = [c for c in range(6) if c not in linear]
        at = np.take_along_axis(apart[:, i], found.case[None], axis=0)[0]
        np.testing.assert_allclose(found.value[:, swept], at[:, swept], rtol=1e-9)
    assert model_of("pid", "ladrc", cases=cases).cases == (Case(0.0),)


def test_the_worst_vehicle_is_the_worst_of_the_corners_and_says_which():
    spread = Spread(inertia=0.2, lag=0.3)
    corners = spread_corners(HUMMINGBIRD, spread)
    assert len(corners) == 4 and len(spread_corners(HUMMINGBIRD, Spread())) == 1
    gains = random_gains("pid", "ladrc", 3, 4, 0.3)
    together = model_of("pid", "ladrc", others=corners).evaluate(gains)
    knowledge = nominal(HUMMINGBIRD, ControlOptions(delay=True), H)
    apart = np.array([
        values(MarginModel(cascade_of("pid", "ladrc"), knowledge, TIMING, vehicle).evaluate(gains))
        for vehicle in (HUMMINGBIRD, *corners)
    ])  # fmt: skip
    i = NAMES.index("sensitivity")
    np.testing.assert_allclose(together.sensitivity.value, apart[:, i].max(axis=0), rtol=1e-9)
    np.testing.assert_array_equal(together.sensitivity.vehicle, apart[:, i].argmax(axis=0))
    assert (together.phase.value <= apart[0, NAMES.index("phase")]).all()


def test_in_attitude_mode_x_and_y_have_no_loop():
    model = model_of("ladrc", "ladrc", trim=Trim(hold=False))
    m = model.evaluate(default_gains("ladrc", "ladrc")[None])
    assert model.blocks == (("z",), ("roll",), ("pitch",), ("yaw",))
    assert m.stable.all()
    for entry in QUANTITIES:
        assert (getattr(m, entry.name).value[:, :2] == entry.open).all()
    assert (model.loop(default_gains("ladrc", "ladrc"), "x").t == 0.0).all()
    # Without the position loop around it, the roll loop has the same crossover and a little more phase.
    outer = model_of("ladrc", "ladrc").evaluate(default_gains("ladrc", "ladrc")[None])
    assert m.crossover.value[0, 3] == pytest.approx(outer.crossover.value[0, 3], rel=0.05)
    assert m.phase.value[0, 3] > outer.phase.value[0, 3]


def test_an_integral_of_gain_zero_is_no_pole_on_the_circle():
    gains = gains_with("pid", "pid", yaw__ki=0.0, z__ki=0.0)
    m = model_of("pid", "pid").evaluate(gains)
    assert m.stable.all()
    assert m.load_index.value[0, 5] == 0.0
    assert np.isinf(m.gain_down.value[0, 5])


def test_load_index_of_a_pid_loop_is_its_integral_gain():
    m = model_of("pid", "pid").evaluate(gains_with("pid", "pid", yaw__ki=37.0, z__ki=0.41))
    assert m.load_index.value[0, 5] == pytest.approx(37.0, rel=1e-6)
    assert m.load_index.value[0, 2] == pytest.approx(0.41, rel=1e-6)


def test_bandwidth_is_where_the_reference_is_followed_to_minus_3_decibel():
    """PD on a double integrator that is fast against its rotors and sampling: y/r = wc^2/(s^2 + 2 zeta wc s + wc^2)."""
    for zeta in (0.7, 1.0):
        m = model_of("pid", "ladrc", ControlOptions()).evaluate(
            gains_with("pid", "ladrc", yaw__omega_c=0.2, yaw__zeta=zeta, yaw__omega_o=20.0)
        )
        a = 1.0 - 2.0 * zeta**2
        assert m.bandwidth.value[0, 5] == pytest.approx(0.2 * np.sqrt(a + np.sqrt(a * a + 1.0)), rel=5e-3)


def test_response_for_plots_agrees_with_the_margins():
    model = model_of("ladrc", "hybrid", cases=(Case(0.2),))
    gains = default_gains("ladrc", "hybrid")
    m = model.evaluate(gains[None])
    for channel in ("x", "z", "roll", "yaw"):
        i = CHANNELS.index(channel)
        at = np.array([getattr(m, name).frequency[0, i] for name in ("sensitivity", "phase", "gain_up")])
        r = model.loop(gains, channel, Case(0.2), at)
        assert abs(r.s[0]) == pytest.approx(m.sensitivity.value[0, i], rel=1e-8)
        assert abs(r.loop[1]) == pytest.approx(1.0, rel=1e-8)
        assert abs(np.angle(-r.loop[1])) == pytest.approx(m.phase.value[0, i], rel=1e-7)
        assert -1.0 / r.loop[2] == pytest.approx(m.gain_up.value[0, i], rel=1e-7)
        assert (abs(model.realisation(gains, channel, Case(0.2)).poles) < 1.0).all()
    assert m.delay_periods[0, 5] == m.delay.value[0, 5] / H
    assert decibel(np.array(10.0)) == 20.0


@cache
def any_loops():
    """Random loops (a, b, c, d = 0) of python-control with unstable poles and zeros outside, whose closed loop is stable."""
    draw = np.random.default_rng(5)
    found = []
    while len(found) < 30:
        order = int(draw.integers(2, 7))
        zeros = draw.uniform(-1.4, 1.4, order - 1)
        poles = np.concatenate([draw.uniform(-0.9, 0.95, order - 1), draw.uniform(0.9, 1.1, 1)])
        system = control.ss(control.zpk(zeros, poles, float(draw.uniform(0.02, 0.6)), H))
        closed = control.feedback(system, 1)
        if np.abs(np.asarray(control.poles(closed))).max(axis=0) < 0.999:
            found.append((system, closed))
    return found


def test_loops_of_any_kind_have_the_margins_of_python_control():
    """Non-minimum phase, open-loop unstable, poles on the negative axis: Ms, Mt and the crossings."""
    grid = frequency_grid(H)
    kinds = {"unstable": 0, "non-minimum phase": 0}
    for system, closed in any_loops():
        kinds["unstable"] += np.abs(np.asarray(control.poles(system))).max(axis=0) > 1.0
        kinds["non-minimum phase"] += np.abs(np.asarray(control.zeros(system))).max(axis=0) > 1.0
        # T from injected to commanded signal is minus the closed loop from the reference.
        modes = modes_of(np.asarray(closed.A)[None])
        found = read_curves(modes, np.asarray(closed.B)[None], -np.asarray(closed.C)[None], grid, H, 0.0)
        loop = system(np.exp(1j * np.linspace(1e-3, np.pi / H, 2001) * H))
        for name, size in (
            ("sensitivity", lambda z: np.abs(1.0 / (1.0 + z))),
            ("complementary", lambda z: np.abs(z / (1.0 + z))),
        ):
            value, at = found[name].value[0, 0], found[name].frequency[0, 0]
            assert value == pytest.approx(size(complex(system(np.exp(1j * max(at, 1e-6) * H)))), rel=1e-6)
            assert value >= size(loop).max(axis=0) * (1.0 - 1e-9)
        up, down = found["gain_up"], found["gain_down"]
        for at, sign in ((up, 1.0), (down, -1.0)):
            if np.isfinite(at.value[0, 0]):
                edge = np.asarray(control.poles(control.feedback(at.value[0, 0] ** sign * system, 1)))
                assert np.abs(np.abs(edge) - 1.0).min(axis=0) < 1e-7
        for factor in np.geomspace(1.0 / min(down.value[0, 0], 30.0), min(up.value[0, 0], 30.0), 12)[1:-1]:
            inside = np.asarray(control.poles(control.feedback(factor * system, 1)))
            assert np.abs(inside).max(axis=0) < 1.0
        if np.isfinite(found["phase"].value[0, 0]):
            at = complex(system(np.exp(1j * found["phase"].frequency[0, 0] * H)))
            assert abs(at) == pytest.approx(1.0, rel=1e-7)
            crossings = loop[:-1][np.diff(np.sign(np.abs(loop) - 1.0)) != 0.0]
            assert found["phase"].value[0, 0] <= np.abs(np.angle(-crossings)).min(axis=0) + 5e-3
    assert min(kinds.values()) > 5


def test_a_pole_on_the_circle_and_a_pole_outside_give_no_margin():
    grid = frequency_grid(H)
    for radius in (1.0, 1.0 + 1e-12, 1.05):
        a = np.array([[[radius * np.cos(0.3), radius * np.sin(0.3)], [-radius * np.sin(0.3), radius * np.cos(0.3)]]])
        modes = modes_of(a)
        assert not modes.stable[0]
        found = read_curves(modes, np.ones((1, 2, 1)), np.ones((1, 1, 2)), grid, H, 0.0)
        assert not np.isnan(found["sensitivity"].value).any()


def test_a_narrow_resonance_between_two_points_of_the_grid_is_found():
    """T = r/((z - p)(z - p*)) with a half-width of 1e-5 of its frequency: the grid is 3 % wide."""
    grid = frequency_grid(H)
    w = float(np.sqrt(grid[0, 200] * grid[0, 201]))
    p = np.exp((-1e-5 + 1j) * w * H)
    a = np.array([[[2.0 * p.real, -(abs(p) ** 2)], [1.0, 0.0]]])
    b, c = np.array([[[1.0], [0.0]]]), np.array([[[0.0, 1e-6]]])
    found = read_curves(modes_of(a), b, c, grid, H, 0.0)["complementary"]
    z = np.exp(1j * w * H)
    assert found.value[0, 0] == pytest.approx(abs(1e-6 / ((z - p) * (z - np.conj(p)))), rel=1e-6)
    assert found.frequency[0, 0] == pytest.approx(w, rel=1e-8)


def test_a_heavier_vehicle_than_the_controller_knows_has_a_lower_crossover():
    gains = default_gains("ladrc", "ladrc")[None]
    knowledge = nominal(HUMMINGBIRD, ControlOptions(), H)
    lighter, heavier = (
        MarginModel(cascade_of("ladrc", "ladrc"), knowledge, TIMING, vary(HUMMINGBIRD, 1.0, factor, 1.0, 1.0)).evaluate(
            gains
        )
        for factor in (0.8, 1.25)
    )
    assert (heavier.crossover.value[:, 3:] < lighter.crossover.value[:, 3:]).all()
    assert (heavier.gain_up.value[:, 3:] > lighter.gain_up.value[:, 3:]).all()
