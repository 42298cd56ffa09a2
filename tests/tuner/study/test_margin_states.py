"""States in which margin limits hold: at hover and in the trims of a study's scenarios, by default, with the worst state named."""

from math import atan2, degrees, hypot

import numpy as np
import pytest

from objectives.margins.margins import MarginModel, spread_corners
from objectives.margins.steady_state import SteadyState
from objectives.margins.trim import Trim
from objectives.requirements import known_values, worst_states, worth_flying
from plant.errors import InputError
from plant.references.spec import VELOCITY
from plant.seeds import generator
from plant.vectors import Vec3
from tests.tuner.conftest import QUICKSTART
from tuner.study.build import load_study
from tuner.study.margins import MarginAnalysis, margin_requirement
from tuner.study.trim import steady_states, trim_texts

STUDIES, TRIM = QUICKSTART.parent, Trim()
LIMITS = [
    {"quantity": "phase_margin", "min": 35.0},
    {"quantity": "gain_margin", "min": 6.0},
    {"quantity": "ms", "max": 2.0},
]


def states_of(study):
    return steady_states([entry.spec for entry in study.scenarios], study.system)


def quickstart(**changed):
    return load_study(QUICKSTART, {"margin": LIMITS} | changed)


@pytest.fixture(scope="module")
def drawn():
    """Rows of the quickstart's search cube that keep its limits at hover, with their values there."""
    study = quickstart()
    points = generator(3, "tests/margin states", 0).uniform(size=(600, len(study.space.variables)))
    gains = study.space.gains(points)
    at_hover = study.screens[0].analyse(gains)
    rows = worth_flying(study.requirements, at_hover)
    assert rows.sum() >= 10
    return study, gains[rows], at_hover[rows]


@pytest.mark.slow
def test_most_gains_that_keep_their_limits_at_hover_break_them_in_the_wind_that_flights_are_trimmed_in(drawn):
    """Against `MarginModel` in each trim by itself; what is told is the worst of all states, and which."""
    study, gains, at_hover = drawn
    (screen,) = study.screens
    speed = study.scenarios[0].spec.air.wind_speed
    system, each = study.system, {"hover": at_hover}
    for degree, way in ((0, (1.0, 0.0)), (45, (0.5**0.5, 0.5**0.5)), (90, (0.0, 1.0))):
        trim = Trim(wind=Vec3(speed * way[0], speed * way[1], 0.0))
        margins = MarginModel(system.cascade, system.nominal, system.timing, system.vehicle, trim).evaluate(gains)
        gain = np.minimum(margins.gain_up.value, margins.gain_down.value).min(axis=1)
        columns = (
            np.degrees(margins.phase.value.min(axis=1)),
            20.0 * np.log10(gain),
            margins.sensitivity.value.max(axis=1),
        )
        each[f"{speed:.3g} m/s wind to {degree} deg"] = np.stack(columns, axis=1)
    values = np.stack(list(each.values()))
    worst = np.stack([values[..., 0].min(axis=0), values[..., 1].min(axis=0), values[..., 2].max(axis=0)], axis=1)
    # All states coupled round otherwise than each by itself: 3e-9 in one margin of 63 on some processors.
    np.testing.assert_allclose(known_values(study.screens, gains, complete=True), worst, rtol=1e-8)
    kept = worth_flying(study.requirements, worst)
    assert kept.mean() < 0.6
    assert screen.states == tuple(each)
    for row, column in zip(gains[:4], values.swapaxes(0, 1)[:4], strict=True):
        named = worst_states(study.screens, row)
        extremes = [column[:, 0].min(), column[:, 1].min(), column[:, 2].max()]
        # Winds to 0 and 90 deg are alike but for rounding, which differs between processors: the first is named.
        at = [np.flatnonzero(np.isclose(column[:, i], extremes[i], rtol=1e-8, atol=0.0))[0] for i in range(3)]
        assert [state.name for state in named.values()] == [screen.states[i] for i in at]


def test_a_search_is_told_a_broken_limit_at_hover_without_trims_and_never_passes_what_breaks_one_in_them(drawn):
    study, gains, _ = drawn
    searched, complete = (known_values(study.screens, gains, complete) for complete in (False, True))
    passing = worth_flying(study.requirements, searched)
    # The trim between the body's axes is left to the end of a search; it decides of few.
    assert np.mean(passing & ~worth_flying(study.requirements, complete)) <= 0.05
    assert not np.any(~passing & worth_flying(study.requirements, complete))
    default = study.default_row[None]
    hover = study.screens[0].analyse(default)
    assert np.array_equal(known_values(study.screens, default), hover)
    assert np.all(known_values(study.screens, default, complete=True)[0, :2] <= hover[0, :2])


def test_hover_alone_is_judged_where_that_is_asked_for(drawn):
    _, gains, at_hover = drawn
    alone = quickstart(margin=[{**limit, "at": "hover"} for limit in LIMITS])
    assert np.array_equal(known_values(alone.screens, gains, complete=True), at_hover)
    assert [entry.label for entry in alone.requirements] == ["phase_margin(hover)", "gain_margin(hover)", "ms(hover)"]
    assert worst_states(alone.screens, gains[0]) == {}
    mixed = quickstart(margin=[LIMITS[0], {**LIMITS[1], "at": "hover"}])
    np.testing.assert_array_equal(known_values(mixed.screens, gains, complete=True)[:, 1], at_hover[:, 1])
    assert np.any(known_values(mixed.screens, gains, complete=True)[:, 0] < at_hover[:, 0])
    with pytest.raises(InputError, match=r"margin\[0\]\.at.*'trim'.*trims"):
        quickstart(margin=[{**LIMITS[0], "at": "trim"}])


def test_the_states_are_the_winds_that_scenarios_can_draw_and_the_speed_of_their_reference():
    names = [state.name for state in states_of(load_study(QUICKSTART))]
    assert names == ["hover", *[f"8.5 m/s wind to {degree} deg" for degree in (0, 45, 90)]]
    given = states_of(quickstart(**{"scenario.0.air.wind_direction_deg": 30.0}))
    assert [state.name for state in given] == ["hover", "8.5 m/s wind to 30 deg"]
    assert degrees(atan2(given[1].wind[1], given[1].wind[0])) == pytest.approx(30.0)
    calm = states_of(quickstart(**{"scenario.0.air.mean_wind": False}))
    assert [state.name for state in calm] == ["hover"]
    eight = load_study(STUDIES / "figure_eight.toml")
    *_, against = states_of(eight)
    velocity = eight.scenarios[0].spec.track(eight.system.timing).samples[:, VELOCITY]
    fastest = velocity[np.argmax(np.linalg.norm(velocity, axis=1))]
    np.testing.assert_allclose(against.velocity, fastest)
    wind = eight.scenarios[0].spec.air.wind_speed
    assert hypot(*against.wind) == pytest.approx(wind)
    np.testing.assert_allclose(np.cross(against.wind, fastest), 0.0, atol=1e-12)
    assert np.dot(against.wind, fastest) < 0.0


def test_a_trim_close_to_the_tilt_limit_is_told_to_leave_little_for_gusts():
    near = load_study(QUICKSTART, {"controller.tilt_limit_deg": 20.0})
    (text,) = trim_texts([entry.spec for entry in near.scenarios], near.system)
    assert "Only 0.7 deg of tilt are left for gusts" in text
    far = load_study(QUICKSTART)
    (text,) = trim_texts([entry.spec for entry in far.scenarios], far.system)
    assert "left" not in text


def test_the_end_of_a_study_reads_waiting_position_loops_exactly():
    study = load_study(STUDIES / "betaflight.toml")
    system, row = study.system, np.array([study.default_row])
    assert system.cascade.position_every > 1
    specs = tuple(entry.spec for entry in study.scenarios)
    limits = tuple(margin_requirement(table, system.timing, specs) for table in study.table.margin)
    ended = MarginAnalysis(limits, system, specs, study.path).by_state(row)[0]
    quick, exact = [
        MarginModel(system.cascade, system.nominal, system.timing, system.vehicle, exact=each).limited(row, limits)
        for each in (False, True)
    ]
    assert np.all(ended == exact)
    assert np.all(np.abs(quick / exact - 1.0) > 1e-6)


def analysis_of(study, limits, **parts):
    """The analysis of limits in the steady states of a study, with the limits as it reads them."""
    specs = tuple(entry.spec for entry in study.scenarios)
    read = tuple(margin_requirement(table, study.system.timing, specs) for table in limits)
    return MarginAnalysis(read, study.system, specs, study.path, **parts), read


def model_of(study, trim=TRIM, **options):
    system = study.system
    return MarginModel(system.cascade, system.nominal, system.timing, system.vehicle, trim, **options)


@pytest.mark.parametrize(("factor", "is_exact"), [(1.02, True), (0.98, True), (1.1, False), (0.5, False)])
def test_values_near_a_limit_are_read_again_exactly_and_others_are_not(factor, is_exact):
    """Beside position loops that wait, a quick margin within 3 % of its limit may be on the wrong side of it."""
    study = load_study(STUDIES / "betaflight.toml")
    row, table = np.array([study.default_row]), study.table.margin[0]
    _, limits = analysis_of(study, [table])
    quick, exact = (model_of(study, exact=each).limited(row, limits)[0, 0] for each in (False, True))
    # Values and limits of phase margins are in degrees.
    moved = table.model_copy(update={"min": float(quick) * factor})
    analysis, _ = analysis_of(study, [moved], states=(SteadyState("hover"),))
    assert quick != exact and analysis.values(row)[0, 0] == (exact if is_exact else quick)


def test_a_search_looks_at_winds_along_the_axes_and_at_a_diagonal_one_where_there_is_no_other():
    study = quickstart()
    rows = np.array([study.default_row])
    hover, weak = SteadyState("hover"), SteadyState("weak", wind=(2.0, 0.0, 0.0))
    strong = SteadyState("strong", wind=(9.0, 0.0, 0.0), is_diagonal=True)

    def searched(*states):
        return analysis_of(study, study.table.margin, states=states)[0].in_search(rows)

    limits = analysis_of(study, study.table.margin)[1]
    alone = {state.name: model_of(study, state.trim).limited(rows, limits) for state in (weak, strong)}
    assert np.all(alone["weak"][0, 1] > alone["strong"][0, 1] + 0.1)
    np.testing.assert_array_equal(searched(hover, weak, strong), alone["weak"])
    np.testing.assert_array_equal(searched(hover, strong), alone["strong"])


def test_a_vehicle_that_cannot_hold_the_wind_has_no_margins_in_it():
    study = quickstart(margin=[{**LIMITS[0], "spread": True}], **{"scenario.0.spread": {"mass": 0.1, "thrust": 0.1}})
    system, spec, row = study.system, study.scenarios[0].spec, np.array([study.default_row])
    corners = spread_corners(system.vehicle, spec.spread)
    winds = [SteadyState("wind", wind=(float(speed), 0.0, 0.0)) for speed in np.arange(5.0, 40.0, 0.25)]
    state = next(
        one
        for one in winds
        if one.can_hold(system.vehicle, system.nominal)
        and 0 < sum(one.can_hold(corner, system.nominal) for corner in corners) < len(corners)
    )
    analysis, limits = analysis_of(study, study.table.margin, states=(state,))
    able = [corner for corner in corners if state.can_hold(corner, system.nominal)]
    value = analysis.values(row)
    np.testing.assert_array_equal(value, model_of(study, state.trim, others=able).limited(row, limits))
    with pytest.raises(InputError, match="no steady flight"):
        model_of(study, state.trim, others=corners)
