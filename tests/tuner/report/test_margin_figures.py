"""Curves, responses, mismatch and figures of `tuner margins --out`, against oracles that do not share their code."""

import numpy as np
import pytest
from matplotlib.image import imread
from scipy.signal import dlsim

from objectives.margins.margins import MarginModel
from objectives.margins.period import CHANNELS
from objectives.margins.trim import Trim
from plant.loop import Timing
from tests.objectives.margins.designs import realisation
from tuner.analysis.margins import mismatch
from tuner.analysis.margins.curves import curves_of, groups
from tuner.analysis.margins.linear import Linear
from tuner.analysis.margins.mismatch import (
    CRITERIA,
    FACTORS,
    margin_surplus,
    mismatch_map,
    tolerance_ranges,
    with_factors,
)
from tuner.analysis.margins.readings import subject_of
from tuner.analysis.margins.time_response import simulate, time_responses
from tuner.api.gains import default_gains
from tuner.report import margin_figures as figures
from tuner.report.margin_figures import disk_circle, mismatch_figure


@pytest.fixture(scope="module")
def hybrid():
    return subject_of(default_gains("hybrid").controller, Trim())


@pytest.fixture(scope="module")
def pid():
    return subject_of(default_gains("pid").controller, Trim())


@pytest.fixture(scope="module")
def linear(hybrid):
    return Linear(hybrid.controller, hybrid.trim)


def model_of(subject, vehicle):
    """Margins of a vehicle whose controller still believes in the nominal one."""
    controller = subject.controller
    timing = Timing(controller.control_period, controller.plant_step)
    return MarginModel(controller.cascade, nominal_of(subject), timing, vehicle, Trim())


def nominal_of(subject):
    from plant.quadrotor.nominal import nominal

    controller = subject.controller
    return nominal(controller.airframe.vehicle, controller.options, controller.control_period)


@pytest.mark.parametrize("factors", [{"mass": 0.7, "inertia": 0.8}, {"inertia": 3.5}, {"mass": 1.3, "lag": 2.0}])
def test_mismatch_is_what_the_eigenvalues_say(hybrid, linear, factors):
    vehicle = with_factors(linear.nominal.vehicle, **factors)
    (judged,) = linear.judge([vehicle])
    model = model_of(hybrid, vehicle)
    for i, channel in enumerate(CHANNELS):
        sizes = [
            np.abs(np.linalg.eigvals(realisation(model, hybrid.row, channel, case).a)).max() for case in model.cases
        ]
        assert judged.stable[0, i] == (max(sizes) < 1.0)
        assert judged.growth[0, i] == pytest.approx(np.log(max(sizes)) / model.control_period, rel=1e-6)
    assert (margin_surplus(judged, "stability", model.control_period) > 0.0) == bool(judged.stable.all())
    assert judged.stable.all() == ("mass" in factors)
    margins = model.evaluate(hybrid.row[None])
    assert np.allclose(judged.sensitivity.value, margins.sensitivity.value, rtol=1e-6)


def test_a_vehicle_far_lighter_than_assumed_has_no_steady_flight_and_its_neighbours_on_the_map_do(linear):
    """The controller asks for a fifth of the weight that it assumes, and no less."""
    light = [linear.judge([with_factors(linear.nominal.vehicle, mass=mass)])[0] for mass in (0.21, 0.19, 0.05)]
    assert [each is None for each in light] == [False, True, True]
    masses, inertias = np.array([0.1, 0.18, 0.25, 1.0]), np.array([1.0, 2.0])
    judged = linear.judge([with_factors(linear.nominal.vehicle, mass=m, inertia=i) for i in inertias for m in masses])
    stability = np.array([margin_surplus(each, "stability", linear.control_period) for each in judged]).reshape(2, 4)
    assert np.array_equal(np.isnan(stability), [[True, True, False, False]] * 2)
    ends = [mismatch.ToleranceRange(factor, name, None, None) for factor in FACTORS for name in CRITERIA]
    entry = mismatch.RobustnessMap("mass", "inertia", masses, inertias, stability, stability)
    mismatch_figure([entry, entry], ends).draw_without_rendering()


def test_slack_is_zero_where_a_limit_is_met_exactly(hybrid, linear):
    (judged,) = linear.judge([linear.nominal.vehicle])
    worst = hybrid.margins.sensitivity.value[0].max()
    limits = (mismatch.LoopLimit("ms", "max", worst),)
    assert margin_surplus(judged, "limits", linear.control_period, limits) == pytest.approx(0.0, abs=1e-9)
    assert margin_surplus(judged, "limits", linear.control_period) < 0.0
    assert np.isnan(margin_surplus(None, "limits", linear.control_period))


def test_a_vehicle_that_cannot_hover_is_no_vehicle(linear):
    assert linear.judge([with_factors(linear.nominal.vehicle, mass=50.0)]) == [None]


def test_extents_end_where_stability_does(pid, monkeypatch):
    monkeypatch.setattr(mismatch, "HALVINGS", 6)
    loop = Linear(pid.controller, pid.trim)
    ends = {(end.factor, end.criterion): end for end in tolerance_ranges(loop)}
    for end in ends.values():
        assert end.row().note is None or None in (end.low, end.high)
    narrow, wide = ends["inertia", "limits"], ends["inertia", "stability"]
    assert (wide.low or 0.0) <= (narrow.low or 0.0) < 1.0 < (narrow.high or 9.0) <= (wide.high or 9.0)
    nearest = narrow.high or narrow.low
    assert nearest is not None
    outwards = 1.03 if narrow.high else 0.97
    inside, outside = loop.judge([with_factors(loop.nominal.vehicle, inertia=f) for f in (nearest, nearest * outwards)])
    assert (
        margin_surplus(inside, "limits", loop.control_period)
        >= 0.0
        > margin_surplus(outside, "limits", loop.control_period)
    )


def test_a_map_is_its_vehicles_and_the_nominal_one_is_on_it(linear):
    ends = [mismatch.ToleranceRange(factor, name, None, None) for factor in FACTORS for name in CRITERIA]
    found = mismatch_map(linear, "mass", "inertia", ends, points=3)
    assert np.allclose(found.x, [0.25, 1.0, 4.0]) and found.stability.shape == (3, 3)
    assert np.isnan(found.stability[:, 2]).all()
    (judged,) = linear.judge([with_factors(linear.nominal.vehicle, inertia=4.0)])
    assert found.stability[2, 1] == pytest.approx(margin_surplus(judged, "stability", linear.control_period))
    assert found.stability[1, 1] > 0.0 > found.stability[2, 1]


def test_curves_touch_the_disk_that_the_disk_margin_keeps_free(hybrid):
    for channel in ("x", "z", "roll", "yaw"):
        i = CHANNELS.index(channel)
        found = hybrid.margins.disk_range
        centre, radius = disk_circle(float(found.low[0, i]), float(found.high[0, i]))
        nearest = np.abs(curves_of(hybrid, channel).loop - centre).min(axis=None)
        # The curve is sampled, so it passes the point of contact at up to half a step.
        assert nearest == pytest.approx(radius, rel=1e-3) and nearest >= radius * (1.0 - 1e-9)


def test_phase_at_the_last_crossover_gives_the_phase_margin(pid):
    for channel in ("z", "roll", "yaw"):
        curves, i = curves_of(pid, channel), CHANNELS.index(channel)
        at = np.argmin(np.abs(curves.frequency - pid.margins.crossover.value[0, i]))
        assert -360.0 < curves.phase[0, at] <= 0.0
        assert curves.gain[0, at] == pytest.approx(0.0, abs=0.2)
        assert 180.0 + curves.phase[0, at] == pytest.approx(np.degrees(pid.margins.phase.value[0, i]), abs=0.5)


def test_loops_that_do_not_differ_share_a_panel(hybrid):
    assert groups(hybrid) == (("x", "y"), ("z",), ("roll", "pitch"), ("yaw",))


def test_simulation_agrees_with_scipy(linear):
    (loops, i, stable), steps = linear.closed("roll"), 200
    assert stable.all() and len(stable) == len(linear.cases)
    column, row = loops.reference.start + i, loops.output.start + i
    ours = simulate(loops, column, row, steps)
    for case in (0, len(linear.cases) - 1):
        a, b, c, d = loops.a[case], loops.b[case][:, [column]], loops.c[case][[row]], loops.d[case][row, column]
        theirs = dlsim((a, b, c, d, linear.control_period), np.ones(steps))[1]
        assert np.allclose(ours[case], theirs[:, 0], rtol=0.0, atol=1e-9)


def test_responses_settle_and_their_area_is_the_load_index(hybrid):
    for response in time_responses(hybrid.controller, hybrid.trim, ("z", "yaw")):
        i = CHANNELS.index(response.channel)
        assert response.step[:, -1] == pytest.approx(1.0, abs=0.03)
        area = hybrid.model.control_period * response.load[0].sum(axis=0)
        assert 1.0 / area == pytest.approx(hybrid.margins.load_index.value[0, i], rel=0.05)


def test_unstable_loops_have_no_response():
    found = subject_of(default_gains("supertwisting").controller, Trim())
    z, roll = time_responses(found.controller, found.trim, ("z", "roll"))
    assert np.isnan(roll.step).all(axis=1).any()
    # Its instability does not leak into a loop that has nothing to do with it.
    assert z.step.shape[0] == 1 and z.step[:, -1] == pytest.approx(1.0, abs=0.03)


@pytest.mark.slow
def test_all_figures_are_written(hybrid, tmp_path, monkeypatch):
    monkeypatch.setattr(mismatch, "POINTS", 5)
    monkeypatch.setattr(mismatch, "HALVINGS", 2)
    monkeypatch.setattr(mismatch, "STEPS", 4)
    ends = figures.write_margin_figures(hybrid, tmp_path)
    assert {(end.factor, end.criterion) for end in ends} == {(f, c) for f in FACTORS for c in CRITERIA}
    for name in ("bode", "nyquist", "nichols", "responses", "mismatch"):
        assert (tmp_path / f"{name}.pdf").read_bytes().startswith(b"%PDF")
        picture = imread(tmp_path / f"{name}.png")
        assert picture.shape[1] == 1420 and picture[..., :3].std() > 0.02


def test_figures_of_loops_that_are_not_stable_can_be_drawn(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(figures, "mismatch_map", lambda *_: None)
    monkeypatch.setattr(figures, "tolerance_ranges", lambda *_: [])
    monkeypatch.setattr(figures, "mismatch_figure", lambda *_: None)
    monkeypatch.setattr(figures, "save", lambda figure, folder, name: drawn.append((name, figure)))
    found = subject_of(default_gains("supertwisting").controller, Trim())
    figures.write_margin_figures(found, tmp_path)
    kept = dict(drawn)
    assert set(kept) == {"bode", "nyquist", "nichols", "responses", "mismatch"}
    kept["responses"].draw_without_rendering()
    said = {text.get_text() for ax in kept["responses"].axes for text in ax.texts}
    assert said and all(text.startswith("stable at ") for text in said)
