"""The margins of a batch of candidates: conventions, worst cases, batches, and loops of any kind against python-control."""

from dataclasses import fields
from functools import cache

import control
import numpy as np
import pytest

from objectives.margins.block import read_curves
from objectives.margins.classical import delay_margin, phase_margin
from objectives.margins.describing import DEFAULT_CASES, Case, term_gains
from objectives.margins.frequency import frequency_grid, modes_of
from objectives.margins.margins import MarginModel, spread_corners
from objectives.margins.period import CHANNELS, constants_of, terms_of
from objectives.margins.quantities import LOOP_QUANTITIES
from objectives.margins.results import Worst, worst
from objectives.margins.trim import Trim
from objectives.scales import decibel
from plant.errors import InputError
from plant.law_registry import LAWS
from plant.quadrotor.nominal import ControlOptions, nominal, vary
from plant.quadrotor.scenarios import Spread
from plant.vectors import Vec3
from tests.objectives.margins.designs import (
    HUMMINGBIRD,
    TIMING,
    H,
    cascade_of,
    default_gains,
    gains_with,
    ideal_vehicle,
    model_of,
    random_gains,
    realisation,
)

NAMES = [entry.field for entry in LOOP_QUANTITIES]
ALL = slice(None)
WIND = Trim(yaw=0.4, wind=Vec3(3.0, 1.0, 0.0))


def values(margins):
    """All quantities (quantities, n, channels)."""
    return np.array([getattr(margins, name).value for name in NAMES])


@pytest.mark.parametrize("name", LAWS)
def test_no_candidate_gives_nan_and_an_unstable_one_no_margin(name):
    model = model_of(name, name, cases=DEFAULT_CASES)
    m = model.evaluate(random_gains(name, name, 10, 1, 3.0))
    found = values(m)
    assert not np.isnan(found).any()
    assert not np.isnan([getattr(m, each).frequency for each in NAMES]).any()
    assert ((m.growth < 0.0) == m.stable).all()
    unstable = ~m.stable
    assert unstable.any() and (m.multiloop.value[unstable.any(axis=1)] == 0.0).all()
    for entry in LOOP_QUANTITIES:
        if entry.field != "crossover":
            assert (getattr(m, entry.field).value[unstable] == entry.unstable).all()
    stable = m.stable
    assert (m.gain_up.value[stable] > 1.0).all() and (m.gain_down.value[stable] > 1.0).all()
    assert (m.phase.value[stable] > 0.0).all() and (m.delay.value[stable] > 0.0).all()
    assert (m.sensitivity.value[stable] >= 1.0).all() and np.isinf(m.sensitivity.value[unstable]).all()


def arrays_of(margins):
    """Everything that depends on the candidate, by name; the first axis of each is that of candidates."""
    found = {}
    for field in fields(margins):
        part = getattr(margins, field.name)
        if isinstance(part, Worst):
            found |= {f"{field.name}.{name}": column for name, column in part._asdict().items()}
        elif isinstance(part, np.ndarray):
            found[field.name] = part
    return found


def assert_same_bits(margins, other, rows):
    wanted = arrays_of(other)
    assert len(wanted) == 2 + 4 * (len(LOOP_QUANTITIES) + 1)
    for name, found in arrays_of(margins).items():
        np.testing.assert_array_equal(found, wanted[name][rows], err_msg=name)


@pytest.mark.parametrize(
    ("pair", "trim"),
    [
        (("ladrc", "hybrid"), Trim()),
        (("hybrid", "ladrc"), WIND),
        (("ladrc", "hybrid"), Trim(hold=False)),
    ],
    ids=lambda value: "-".join(value) if not isinstance(value, Trim) else "wind" if value.moves else str(value.hold),
)
def test_a_candidate_has_its_bits_whatever_else_is_in_the_batch(pair, trim, monkeypatch):
    """On vehicles that are not the nominal one, where steady flight is found by iteration."""
    corners = spread_corners(HUMMINGBIRD, Spread(mass=0.15, inertia=0.2, thrust=0.1, lag=0.3))[6:11:4]
    model = model_of(pair[0], pair[1], trim=trim, cases=(Case(0.0), Case(0.2), Case(None)), others=corners)
    gains = random_gains(pair[0], pair[1], 3, 2, 0.5)
    whole = model.evaluate(gains)
    assert whole.stable.any()
    assert_same_bits(model.evaluate(gains[1:2]), whole, slice(1, 2))
    # In another order, and in two parts.
    order = np.array([2, 0, 1])
    monkeypatch.setattr("objectives.margins.loop_margins.CHUNK", 2)
    assert_same_bits(model.evaluate(gains[order]), whole, order)


@pytest.mark.parametrize("pair", [("pid", "ladrc"), ("ladrc", "hybrid")], ids="-".join)
def test_no_candidates_have_no_margins(pair):
    model = model_of(pair[0], pair[1], others=spread_corners(HUMMINGBIRD, Spread(mass=0.1)))
    some, none = (arrays_of(model.evaluate(random_gains(pair[0], pair[1], n, 1))) for n in (2, 0))
    for name, found in none.items():
        assert found.shape == (0, *some[name].shape[1:]) and found.dtype == some[name].dtype, name


def test_vehicles_far_lighter_than_assumed_have_margins_or_no_steady_flight():
    """The controller asks for 20 % of the weight that it assumes, and no less: below that a lighter vehicle must climb."""
    gains = default_gains("pid", "ladrc")[None]
    assumed = ideal_vehicle(0.02)
    knowledge = nominal(assumed, ControlOptions(delay=True), H)
    whole = MarginModel(cascade_of("pid", "ladrc"), knowledge, TIMING, assumed).evaluate(gains)
    for mass in (0.5, 0.3, 0.21):
        lighter = vary(assumed, mass, 1.0, 1.0, 1.0)
        found = MarginModel(cascade_of("pid", "ladrc"), knowledge, TIMING, lighter).evaluate(gains)
        assert found.stable[0, 2]
        # Without drag the mass is a factor on the loop gain of z and nothing else.
        assert found.gain_up.value[0, 2] == pytest.approx(whole.gain_up.value[0, 2] * mass, rel=1e-7)
        assert found.gain_down.value[0, 2] == pytest.approx(whole.gain_down.value[0, 2] / mass, rel=1e-7)
    for mass in (0.19, 0.18, 0.1, 0.03, 0.001):
        with pytest.raises(InputError, match="no steady flight"):
            MarginModel(cascade_of("pid", "ladrc"), knowledge, TIMING, vary(assumed, mass, 1.0, 1.0, 1.0))


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
    for i, entry in enumerate(LOOP_QUANTITIES):
        found = getattr(together, entry.field)
        worst = apart[:, i].min(axis=0) if entry.sense == "min" else apart[:, i].max(axis=0)
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
    apart = np.array(
        [
            values(MarginModel(cascade_of("pid", "ladrc"), knowledge, TIMING, vehicle).evaluate(gains))
            for vehicle in (HUMMINGBIRD, *corners)
        ]
    )
    i = NAMES.index("sensitivity")
    np.testing.assert_allclose(together.sensitivity.value, apart[:, i].max(axis=0), rtol=1e-9)
    np.testing.assert_array_equal(together.sensitivity.vehicle, apart[:, i].argmax(axis=0))
    assert (together.phase.value <= apart[0, NAMES.index("phase")]).all()


def test_in_attitude_mode_x_and_y_have_no_loop():
    model = model_of("ladrc", "ladrc", trim=Trim(hold=False))
    m = model.evaluate(default_gains("ladrc", "ladrc")[None])
    assert model.blocks == (("z",), ("roll",), ("pitch",), ("yaw",))
    assert m.stable.all()
    for entry in LOOP_QUANTITIES:
        assert (getattr(m, entry.field).value[:, :2] == entry.open).all()
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
        assert (abs(np.linalg.eigvals(realisation(model, gains, channel, Case(0.2)).a)) < 1.0).all()
    assert m.delay_periods[0, 5] == m.delay.value[0, 5] / H
    assert decibel(np.array(10.0)) == 20.0


def test_curves_of_a_batch_are_those_of_each_loop_by_itself():
    model, frequency = model_of("ladrc", "hybrid", cases=(Case(0.0), Case(0.2))), np.array([0.3, 3.0, 30.0])
    gains = np.stack([default_gains("ladrc", "hybrid"), gains_with("ladrc", "hybrid", roll__omega_o=20.0)[0]])
    cases = np.array([[0, 0, 1, 0, 0, 1], [1, 0, 0, 1, 1, 0]])
    found = model.curves(gains, cases, frequency)
    for row, channels in enumerate(cases):
        for i, case in enumerate(channels):
            alone = model.loop(gains[row], CHANNELS[i], model.cases[case], frequency).loop
            np.testing.assert_allclose(found[row, i], alone, rtol=1e-9)
    assert not np.allclose(found[1, CHANNELS.index("roll")], found[1, CHANNELS.index("pitch")], rtol=1e-3)


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
        modes = modes_of(np.asarray(closed.A)[None], np.asarray(closed.B)[None], -np.asarray(closed.C)[None])
        found = read_curves(modes, modes.residues(ALL, ALL), grid, H, 0.0)
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


@pytest.mark.parametrize(
    ("angle", "poles"), [(0.995 * np.pi, (0.0, -0.5)), (2e-5, (0.99999, 0.9999))], ids=["last", "first"]
)
def test_a_gain_margin_in_the_first_or_last_interval_of_the_grid_is_found(angle, poles):
    """Two loop poles that a gain 1.25 times as large takes to exp(+-j angle)."""
    start, end = np.poly(poles), np.array([1.0, -2.0 * np.cos(angle), 1.0])
    closed = start + 0.8 * (end - start)
    a = np.array([[-closed[1:], [1.0, 0.0]]])
    b, c = np.array([[[1.0], [0.0]]]), np.array(-0.8 * (end - start)[None, None, 1:], dtype=float)
    modes = modes_of(a, b, c)
    found = read_curves(modes, modes.residues(ALL, ALL), frequency_grid(H), H, 0.0)["gain_up"]
    assert found.value[0, 0] == pytest.approx(1.25, rel=1e-6)
    assert found.frequency[0, 0] == pytest.approx(angle / H, rel=1e-6)


@pytest.mark.parametrize("b", [-3.0, -0.2, 0.2, 3.0])
def test_the_delay_margin_turns_a_loop_to_minus_one_whichever_side_it_crosses_on(b):
    w, t = 7.0, -0.5 + 1j * b
    loop = -t / (1.0 + t)
    line = np.array([[w, b], [np.nan, np.nan]])
    delay, phase = delay_margin(line), phase_margin(line)
    assert abs(loop) == pytest.approx(1.0)
    assert loop * np.exp(-1j * w * delay.value) == pytest.approx(-1.0)
    assert 0.0 < delay.value < 2.0 * np.pi / w
    assert phase.value == pytest.approx(abs(np.angle(-loop)))
    nothing = np.full((2, 2), np.nan)
    assert delay_margin(nothing) == phase_margin(nothing) == (np.inf, 0.0)


def test_a_pole_on_the_circle_and_a_pole_outside_give_no_margin():
    grid = frequency_grid(H)
    for radius in (1.0, 1.0 + 1e-12, 1.05):
        a = np.array([[[radius * np.cos(0.3), radius * np.sin(0.3)], [-radius * np.sin(0.3), radius * np.cos(0.3)]]])
        modes = modes_of(a, np.ones((1, 2, 1)), np.ones((1, 1, 2)))
        assert not modes.stable[0]
        found = read_curves(modes, modes.residues(ALL, ALL), grid, H, 0.0)
        assert not np.isnan(found["sensitivity"].value).any()


def resonance(top, half_width):
    """Modes and frequency of T = R/(z - p) + conjugate that reaches `top`, midway between two points of the grid."""
    grid = frequency_grid(H)
    w = float(np.sqrt(grid[0, 200] * grid[0, 201]))
    p = np.exp((-half_width + 1j) * w * H)
    r = top * half_width * w * H * np.exp(1j * w * H)
    a = np.array([[[p.real, p.imag], [-p.imag, p.real]]])
    return modes_of(a, np.array([[[1.0], [0.0]]]), 2.0 * np.array([[[r.real, r.imag]]])), w


def test_a_narrow_resonance_between_two_points_of_the_grid_is_found():
    """Its half-width is 1e-5 of its frequency, the grid is 3 % wide: T runs round a circle from 0 to -2 and back in between."""
    modes, w = resonance(-2.0, 1e-5)
    found = read_curves(modes, modes.residues(ALL, ALL), frequency_grid(H), H, 0.0)
    assert found["complementary"].value[0, 0] == pytest.approx(2.0, rel=1e-4)
    assert found["complementary"].frequency[0, 0] == pytest.approx(w, rel=1e-8)
    # On that circle |L| is 1 where T = -1/2 +- j sqrt(3)/2, and there L = exp(-+ 2j pi/3).
    assert found["phase"].value[0, 0] == pytest.approx(np.pi / 3.0, rel=1e-4)
    # It is real at -2, where L falls on -1 for half the gain.
    assert found["gain_down"].value[0, 0] == pytest.approx(2.0, rel=1e-4)


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


@pytest.mark.parametrize("amplitude", [0.02, 0.3, 5.0])
def test_the_hybrid_law_is_ladrc_with_gains_that_depend_on_amplitude(amplitude):
    """Linear in S it is PD with kp = lambda k, kd = lambda + k, k = k2 + k1 N(A), on the same observer."""
    hybrid = gains_with("pid", "hybrid", yaw__lambda=4.0, yaw__k1=15.0, yaw__k2=6.0, yaw__delta=0.3, yaw__omega_o=14.0)
    cascade = cascade_of("pid", "hybrid")
    k = term_gains(terms_of(cascade), constants_of(cascade, hybrid, H), 1, (Case(amplitude),))[0, 0, 2]
    wc = np.sqrt(4.0 * k)
    ladrc = gains_with("pid", "ladrc", yaw__omega_c=wc, yaw__zeta=(4.0 + k) / (2.0 * wc), yaw__omega_o=14.0)
    one = model_of("pid", "hybrid", cases=(Case(amplitude),)).evaluate(hybrid)
    other = model_of("pid", "ladrc").evaluate(ladrc)
    # A gain of 0.008 dB is the logarithm of a number near 1, whose rounding differs by 4e-10 between versions of Python.
    np.testing.assert_allclose(values(one)[:, 0, 5], values(other)[:, 0, 5], rtol=1e-8, atol=1e-9)


def test_the_published_gains_fail_45_degrees_at_every_amplitude():
    """wo = 10 rad/s, k1 = 20, rate from the observer, 20 ms of rotor lag and a period of 4 ms; slopes open in the source."""
    options = ControlOptions(attitude_rate="observer", lag_aware=False, delay=True)
    model = model_of("pid", "hybrid_literal", options, vehicle=ideal_vehicle(0.02))
    for slope in (2.0, 5.0):
        gains = gains_with("pid", "hybrid_literal", yaw__omega_o=10.0, yaw__k1=20.0, yaw__k2=5.0, yaw__lambda=slope)
        found = []
        for amplitude in np.geomspace(1e-3, 30.0, 10).tolist():
            # The case is all that changes: the model is built once.
            model.cases = (Case(amplitude),)
            found.append(np.degrees(model.evaluate(gains).phase.value[0, 5]))
        assert 15.0 < min(found) < max(found) < 36.0


def test_of_conditions_that_are_alike_the_first_one_is_named() -> None:
    values = np.array([[2.0, 1.0 + 1e-9, 1.0], [np.inf, 3.0, np.inf], [np.inf, np.inf, np.inf]])
    frequency = np.arange(9.0).reshape(3, 3)
    found = worst(values[:, None, :, None], frequency[:, None, :, None], "min", np.array([[0, 1, 2]]))
    assert found.value[:, 0].tolist() == [1.0, 3.0, np.inf]
    assert found.case[:, 0].tolist() == [1, 1, 0] and found.frequency[:, 0].tolist() == [1.0, 4.0, 6.0]
    found = worst(values[:, None, :, None], frequency[:, None, :, None], "max", np.array([[0, 1, 2]]))
    assert found.case[:, 0].tolist() == [0, 0, 0] and found.value[1:, 0].tolist() == [np.inf, np.inf]
