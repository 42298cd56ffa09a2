"""Stability margins as requirements of a study: what [[margin]] tables become, and that what a run offers has them.

The oracle for the latter takes nothing from the analysis: the flown code, stepped in plain Python about hover, differentiated
numerically, its sliding term replaced by a straight line whose gain scipy integrates.
"""

from itertools import product
from math import pi

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import quad

import objectives.evaluator
from objectives.margins.describing import DEFAULT_CASES
from objectives.margins.margins import MarginModel
from objectives.margins.period import constants_of, terms_of
from objectives.margins.quantities import LIMITABLE
from objectives.margins.trim import Trim, smooth_dynamics
from objectives.problem import Problem
from objectives.requirements import LARGEST_VIOLATION, known_values
from plant.backends import array
from plant.errors import InputError, UnknownNameError
from plant.quadrotor.rigid_body import Body
from plant.quadrotor.sample import Targets
from plant.quadrotor.sensors import Noise
from plant.quadrotor.trim import trim_of
from plant.records import flatten, pack, paths, size
from plant.vectors import Vec3
from tests.objectives.margins.stepping import Stepper
from tests.tuner.conftest import QUICKSTART, SMALL, NoDrawing
from tests.tuner.study.study_text import STUDY, changed, write
from tuner import report
from tuner.analysis import finals
from tuner.api.catalogue import listings
from tuner.experiments.again.verify import verify
from tuner.experiments.tuning.finalists import finalists_of
from tuner.experiments.tuning.run import TuningRun
from tuner.experiments.tuning.search import algorithm_of, first_points, search
from tuner.experiments.tuning.survivors import survivors_of
from tuner.search.initial_design import initial_design
from tuner.search.loop import archive
from tuner.search.watcher import Watcher
from tuner.store.folder import Folder
from tuner.study.build import load_study
from tuner.study.margins import nominal_margins

# Searched as the quickstart asks: by a model that asks for margins between flights.
REQUIRED = {key: value for key, value in SMALL.items() if key not in ("margin", "search.algorithm")} | {
    "search.population": 16,
    "search.generations": 3,
    "scenario.0.duration": 4.0,
    "scenario.0.reference.time": 0.1,
}
PHASE = '[[margin]]\nquantity = "phase_margin"\naxis = "tilt"\nmin = 35\n'
PEAK = '[[margin]]\nquantity = "ms"\nmax = 2\n'
CORNERS = '[[margin]]\nquantity = "phase_margin"\naxis = "tilt"\nmin = 35\nspread = true\n'
IRIS = changed('"hummingbird"', '"iris"')
TWISTING_GAINS = '"x.omega_c" = {}\n"attitude.lambda" = 6.0\n"attitude.k1" = 6.0\n"attitude.k2" = 1.0'
TOGETHER = '[[margin]]\nquantity = "multiloop_disk"\nmin = 0.4\n'


def study(folder, lines, text=STUDY):
    return load_study(write(folder, f"{text}\n{lines}"))


def searched(folder, asked, threads=2):
    """All candidates of a search, and what is warned of; nothing is re-flown or reported."""
    problem = Problem(
        asked.system, asked.space, asked.objectives, asked.constraints, asked.seed, threads, asked.screens
    )
    results = Folder.create(folder)
    first, _ = first_points(problem, asked, results)
    generations = search(problem, asked, results, Watcher(), algorithm_of(problem, asked, first), asked.search.budget)
    found, survivors = archive(generations), survivors_of(problem, asked, generations, Watcher())
    return found, finalists_of(survivors, found, asked)[1]


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "margins"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report, "start_figures", lambda _: NoDrawing())
        patch.setattr(report, "write_report", lambda *_: None)
        run = TuningRun(load_study(QUICKSTART, REQUIRED), Folder.create(folder), Watcher(), threads=2)
        return run.carry_out(), folder


@pytest.mark.slow
@pytest.mark.parametrize(
    ("factor", "differs"),
    [(1.0 + 3e-14, ""), (1.0 - 1e-5, "phase_margin"), (1.0 + 1e-5, "phase_margin")],
)
def test_margins_may_move_in_their_last_digits_when_a_run_is_verified(ran, monkeypatch, factor, differs):
    for module in (objectives.evaluator, finals):
        monkeypatch.setattr(module, "known_values", lambda *asked, **named: known_values(*asked, **named) * factor)
    found = verify(ran[1], 2, 2, Watcher())
    assert found.same is not bool(differs) and not found.identical
    assert differs in (found.difference or "")
    if not differs:
        assert 1e-14 < found.margins_moved < 1e-13
        assert found.words.startswith("The same but for the last digits of margins: 48 candidates replayed, 2 of them")
        assert "margins agree to 13 digits, all else to the bit" in found.words


def spied(monkeypatch):
    """Count how often margin models are made and asked, and of how many vehicles."""
    made, asked = [], []

    class Spy(MarginModel):
        def __init__(self, *arguments, **named):
            super().__init__(*arguments, **named)
            made.append(len(self.vehicles))

        def limited(self, gains, requirements):
            asked.append((len(self.vehicles), len(gains)))
            return super().limited(gains, requirements)

    monkeypatch.setattr("objectives.margins.margins.MarginModel", Spy)
    nominal_margins.cache_clear()
    return made, asked


def test_all_tables_share_one_evaluation_for_each_choice_of_vehicles(tmp_path, monkeypatch):
    made, evaluated = spied(monkeypatch)
    asked = study(tmp_path, PHASE + PEAK + CORNERS + TOGETHER)
    (screen,) = asked.screens
    assert [entry.label for entry in screen.requirements] == [
        "phase_margin(tilt)",
        "ms",
        "phase_margin(tilt, spread)",
        "multiloop_disk",
    ]
    # Nothing is built before it is needed.
    assert made == []
    rows = np.stack([asked.default_row, 0.9 * asked.default_row])
    values = screen.analyse(rows)
    # STUDY spreads the mass, and the rotor lag as every study does: the nominal vehicle and four corners.
    assert (sorted(made), sorted(evaluated)) == ([1, 5], [(1, 2), (5, 2)])
    # What is known is not worked out again, and by itself a candidate has the margins that it has beside others.
    assert np.array_equal(screen.analyse(rows[::-1]), values[::-1])
    assert (len(made), len(evaluated)) == (2, 2)
    (alone,) = study(tmp_path, PHASE + PEAK + CORNERS + TOGETHER).screens
    assert np.array_equal(alone.analyse(rows[1:]), values[1:])
    assert np.all(values[:, 2] <= values[:, 0])
    model = MarginModel(asked.system.cascade, asked.system.nominal, asked.system.timing, asked.system.vehicle)
    margins = model.evaluate(rows)
    np.testing.assert_allclose(np.radians(values[:, 0]), margins.phase.value[:, 3:5].min(axis=1), rtol=1e-12)
    assert np.array_equal(values[:, 1], margins.sensitivity.value.max(axis=1))
    assert np.array_equal(values[:, 3], margins.multiloop.value)


def test_search_and_documents_share_the_model_of_a_state(tmp_path, monkeypatch):
    made, _ = spied(monkeypatch)
    asked = study(tmp_path, PHASE)
    known_values(asked.screens, asked.default_row[None])
    asked.margin_model().evaluate(asked.default_row[None])
    assert made == [1]


def test_every_quantity_can_be_asked_for_and_is_listed(tmp_path):
    lines = [
        f'[[margin]]\nquantity = "{name}"\n{quantity.sense} = {1.5 if quantity.sense == "max" else 0.01}\n'
        for name, quantity in LIMITABLE.items()
    ]
    asked = study(tmp_path, "".join(lines))
    assert [entry.label for entry in asked.requirements] == list(LIMITABLE)
    assert not np.isnan(known_values(asked.screens, asked.default_row[None])).any()
    rows = listings()["margins"]()
    assert [row["quantity"] for row in rows] == list(LIMITABLE)
    assert {str(row["unit"]) for row in rows} == {"dB", "deg", "s", "1", "rad/s", "s^-3"}


def test_a_hard_limit_and_a_target_on_the_same_number_go_together(tmp_path):
    asked = study(tmp_path, PHASE + PHASE.replace("35", "45") + "hard = false\n")
    assert [(entry.label, entry.limit, entry.hard) for entry in asked.requirements] == [
        ("phase_margin(tilt)", 35.0, True),
        ("phase_margin(tilt, soft)", 45.0, False),
    ]
    values = known_values(asked.screens, asked.default_row[None])
    assert values[0, 0] == values[0, 1]


def test_a_square_root_has_margins_from_some_amplitude_on(tmp_path):
    twisting = changed('attitude = "hybrid"', 'attitude = "supertwisting"')
    twisting = changed('"tilt.lambda" = { low = 1, high = 16 }\n"roll.k1" = 20.0', TWISTING_GAINS, twisting)
    wide = PEAK + 'axis = "tilt"\n'
    asked = study(tmp_path, wide + wide + "amplitude = 0.5\n" + wide + "amplitude = 1.0\n", twisting)
    assert [entry.label for entry in asked.requirements] == ["ms(tilt)", "ms(tilt, from 0.5)", "ms(tilt, from 1)"]
    every, some, few = known_values(asked.screens, asked.default_row[None])[0]
    assert every == np.inf > some >= few
    assert "amplitudes of 0.5 and more" in asked.requirements[1].quantity


def test_attitude_mode_has_no_loops_of_x_and_y(tmp_path):
    level = changed('kind = "steps"\nx = 1.0\ntime = 0.5', 'kind = "level"').replace(
        'metric = "itae.position"', 'metric = "itae.tilt"'
    )
    asked = study(tmp_path, PEAK, level)
    assert "worst of z, roll, pitch, yaw" in asked.requirements[0].quantity
    assert np.isfinite(known_values(asked.screens, asked.default_row[None])).all()
    with pytest.raises(InputError, match="every scenario flies in attitude mode, where x and y are open") as caught:
        study(tmp_path, PEAK + 'axis = "horizontal"\n', level)
    assert caught.value.key == "margin[0].axis"


# Text after the study, key, what the message must say.
BAD = [
    (PHASE.replace("phase_margin", "phase_margn"), "margin[0].quantity", "did you mean 'phase_margin'?"),
    (PHASE.replace("tilt", "tild"), "margin[0].axis", "did you mean 'tilt'?"),
    (PHASE.replace("min =", "minn ="), "margin[0].minn", "did you mean 'min'?"),
    (PHASE.replace("min =", "max ="), "margin[0].max", "larger values are better; give min instead"),
    (PHASE + "max = 60\n", "margin[0].max", "larger values are better; give min instead"),
    (PEAK.replace("max =", "min ="), "margin[0].min", "smaller values are better; give max instead"),
    (PHASE.replace("min = 35", ""), "margin[0].min", "write min = ... in deg"),
    (PEAK.replace("max = 2", ""), "margin[0].max", "'ms' needs a limit; write max = ..."),
    (PHASE.replace("35", "0"), "margin[0].min", "allowed: above 0 and below 180 deg"),
    (PHASE.replace("35", "nan"), "margin[0].min", "a finite number"),
    (PEAK.replace("2", "1"), "margin[0].max", "given 1; allowed: above 1"),
    (TOGETHER.replace("0.4", "2"), "margin[0].min", "allowed: above 0 and below 2"),
    (TOGETHER + 'axis = "tilt"\n', "margin[0].axis", "takes all loops at once; leave axis out"),
    (PEAK + PHASE + PHASE, "margin[2]", "'phase_margin(tilt)' occurs twice, first as margin[1]"),
    (PHASE + "amplitude = -1\n", "margin[0].amplitude", "given -1; allowed: 0 to 2"),
    (PHASE + "hard = 1\n", "margin[0].hard", "true or false"),
    (PHASE + 'spread = "yes"\n', "margin[0].spread", "true or false"),
    ("[[margin]]\nmin = 35\n", "margin[0].quantity", 'write quantity = "phase_margin"'),
    (PHASE.replace("[[margin]]", "[margin]"), "margin", "double brackets: [[margin]]"),
]  # fmt: skip


@pytest.mark.parametrize(("lines", "key", "says"), BAD, ids=[f"{row[1]}: {row[2]:.30}" for row in BAD])
def test_a_bad_margin_is_refused(lines, key, says, tmp_path):
    path = write(tmp_path, f"{STUDY}\n{lines}")
    with pytest.raises(InputError) as caught:
        load_study(path)
    assert (caught.value.file, caught.value.key) == (str(path), key)
    assert says in caught.value.message
    if "did you mean" in says:
        assert isinstance(caught.value, UnknownNameError)


def test_a_spread_that_no_scenario_has_is_refused(tmp_path):
    with pytest.raises(InputError, match="no scenario spreads the airframe") as caught:
        study(tmp_path, CORNERS, changed("mass = 0.1", "mass = 0.0\nlag = 0.0"))
    assert caught.value.key == "margin[0].spread"


def test_a_corner_that_cannot_hover_is_told_with_the_file(tmp_path):
    # Half as heavy again on half the thrust: it takes three times the thrust of hover, and an iris has 1.9 times of it.
    asked = study(tmp_path, CORNERS, changed("mass = 0.1", "mass = 0.5\nthrust = 0.5", IRIS))
    with pytest.raises(InputError, match="no steady flight") as caught:
        known_values(asked.screens, asked.default_row[None])
    assert (caught.value.file, caught.value.key) == (str(asked.path), "margin")


def test_what_is_offered_keeps_every_requirement_and_the_default_is_judged_honestly(ran):
    outcome, folder = ran
    front = pd.read_csv(folder / "front.csv")
    columns = [f"requirement:{entry.label}" for entry in outcome.study.requirements]
    assert len(front) > 2
    for column, entry in zip(columns, outcome.study.requirements, strict=True):
        assert np.all(
            entry.violations(
                front[column].to_numpy()[1:] if entry.scale is None else entry.scale.shown(front[column].to_numpy()[1:])
            )
            <= 1e-12
        ), column
    # The published gains of the hybrid have a phase margin of 12 deg with 20 ms of lag.
    assert not front["feasible"].to_numpy()[0]
    assert front["requirement:phase_margin"].to_numpy()[0] < np.radians(35.0)


def test_the_first_generation_is_worth_flying(ran):
    outcome, _ = ran
    # Of the search cube 3 % keep the margins at hover, and a third of these in the wind.
    assert outcome.generations[0].evaluation.flown.mean() > 0.3


def test_a_first_generation_gives_up_only_what_is_not_worth_a_flight():
    def points(excess=None):
        return initial_design(np.full((1, 3), 0.5), 64, np.random.default_rng(7), excess)

    plain = points()
    assert np.array_equal(points(lambda x: -np.ones((len(x), 1))), plain)
    assert np.array_equal(points(lambda x: np.ones((len(x), 1))), plain)
    some = points(lambda x: x[:, :1] - 0.05)
    # 5 % of 48 hypercubes of 63 points are far more than the 60 places to fill; each starting point stays.
    assert np.all(some[1:, 0] < 0.05) and np.array_equal(some[0], plain[0])
    kept = plain[:, 0] < 0.05
    assert np.array_equal(some[kept], plain[kept]) and len(np.unique(some, axis=0)) == 64


def test_a_first_generation_evolves_where_no_drawn_point_is_worth_a_flight():
    """All but a ball of 4e-6 of the cube is unstable or nearly so, as on an airframe whose default gains are unstable."""

    def excess(points):
        distance = np.abs(points - np.array([0.02, 0.9, 0.4])).max(axis=1, keepdims=True) - 0.008
        return np.where(distance > 0.2, [1.0, 1e6], np.hstack([distance, 100.0 * distance]))

    start = np.full((1, 3), 0.5)
    first = initial_design(start, 16, np.random.default_rng(7), excess)
    assert np.array_equal(first[0], start[0])
    assert np.all(excess(first[1:]) <= 0.0) and len(np.unique(first, axis=0)) == 16
    # The drawn points alone would be lost.
    assert not np.any(np.all(excess(initial_design(start, 16, np.random.default_rng(7))) <= 0.0, axis=1))


def test_screening_and_flying_are_timed(ran):
    outcome, folder = ran
    history = pd.read_csv(folder / "history.csv")
    both = history.screening_seconds + history.flight_seconds
    assert history.screening_seconds.is_monotonic_increasing and history.flight_seconds.is_monotonic_increasing
    assert (both <= history.seconds).all() and (history.screening_seconds > 0.0).all()


def numerical(stepper, state, gains):
    """A (x, x), and from the injected signals B (x, 6) and C (6, x), of the flown code, by central differences."""

    x = len(state)
    step = np.concatenate([1e-6 * np.maximum(np.abs(state), 1.0), np.full(6, 1e-4)])
    # All steps side by side, forwards and backwards: a column is a flight.
    moved = np.concatenate([state, np.zeros(6)])[:, None] + np.concatenate([np.diag(step), -np.diag(step)], axis=1)
    v = moved[x:]
    parts = stepper.step(moved[:x], gains[:, None] + 0.0 * v[:1], lambda *_: v[:2], lambda *_: v[2:])[:2]
    ahead, behind = np.split(np.concatenate([whole(part, v) for part in parts]), 2, axis=1)
    slope = (ahead - behind) / (2.0 * step)
    return slope[:x, :x], slope[:x, x:], slope[x:, :x]


def whole(rows, v):
    """Rows as one array, those that are the same in all flights repeated."""
    return np.array([np.broadcast_to(row, v.shape[1:]) for row in rows])


def straight_gains(asked, gains, case):
    """Gain of each nonlinear term: its describing function as scipy integrates it, its slope at rest, or its steepest."""
    constants = constants_of(asked.system.cascade, gains[None], asked.system.timing.control_period)
    found = []
    for term in terms_of(asked.system.cascade):
        own = getattr(constants, term.axis)
        own = type(own)(*[float(np.ravel(part)[0]) for part in own])

        def f(s, function=term.nonlinearity.function, own=own):
            return function(s, own)

        if case.amplitude:
            a = case.amplitude
            first = quad(lambda t, a=a: f(a * np.sin(t)) * np.sin(t), 0.0, pi / 2, limit=500)[0]
            found.append(4.0 / (pi * a) * first)
        elif case.amplitude == 0.0:
            found.append((f(1e-9) - f(-1e-9)) / 2e-9)
        else:
            # |s|^(1/2) s/delta is steepest just inside its corner, at delta.
            corner = 1.0 / own.per_delta
            found.append((f(corner) - f(corner * (1.0 - 1e-6))) / (1e-6 * corner))
    return np.array(found)


def read_off(a, b, c, h):
    """Worst phase margin [deg], gain margin [dB], Ms and delay margin [periods] of six loops on a dense grid; None if unstable."""
    w = np.geomspace(0.02, np.pi / h * 0.9999, 12000)
    values, vectors = np.linalg.eig(a)
    left = np.linalg.solve(vectors, b)
    phase, gain, peak, delay = [], [], [], []
    for i in range(6):
        t = ((c[i] @ vectors) * left[:, i] / (np.exp(1j * w * h)[:, None] - values)).sum(axis=1)
        loop = -t / (1.0 + t)
        peak.append(np.max(np.abs(1.0 + t), axis=0))
        size, angle = np.log(np.abs(loop)), np.unwrap(np.angle(loop))
        at = np.flatnonzero(np.diff(np.sign(size)))
        part = size[at] / (size[at] - size[at + 1])
        lag = np.mod(angle[at] + part * (angle[at + 1] - angle[at]) + pi, 2.0 * pi)
        phase += np.minimum(lag, 2.0 * pi - lag).tolist()
        delay += (lag / (w[at] + part * (w[at + 1] - w[at])) / h).tolist()
        turns = (angle - pi) / (2.0 * pi)
        at = np.flatnonzero(np.diff(np.floor(turns)))
        part = (np.round(turns[at]) - turns[at]) / (turns[at + 1] - turns[at])
        gain += np.abs(size[at] + part * (size[at + 1] - size[at])).tolist()
    return np.array([np.degrees(min(phase)), 20.0 / np.log(10.0) * min(gain), max(peak), min(delay)])


# Members of a front whose margins are worked out by the flown code, 2 s each for four states: the recommended one, and another.
@pytest.mark.parametrize("place", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_members_of_the_front_keep_their_margins_by_a_path_of_their_own(ran, place):
    outcome, folder = ran
    asked, front = outcome.study, pd.read_csv(folder / "front.csv")
    assert [entry.label for entry in asked.requirements] == ["phase_margin", "gain_margin", "ms", "delay_periods"]
    told = front[[f"requirement:{entry.label}" for entry in asked.requirements]].to_numpy()
    offered = np.flatnonzero(front["feasible"].to_numpy() & front["non_dominated"].to_numpy())
    assert len(offered) > 2 and outcome.tuned in offered
    member = [outcome.tuned, *offered[offered != outcome.tuned]][place]
    expected = by_own_path(asked, outcome.gains(member))
    for entry, value, mine in zip(asked.requirements, told[member], expected, strict=True):
        assert value == pytest.approx(entry.in_file(mine), rel=1e-4), (member, entry.label)
        assert entry.is_satisfied(np.array([mine]))[0], (member, entry.label)


def by_own_path(asked, gains):
    """Phase margin, gain margin, Ms and delay margin of gains in the worst loop, amplitude and steady state."""
    system, h = asked.system, asked.system.timing.control_period
    worst = []
    speed = asked.scenarios[0].spec.air.wind_speed
    winds = [(0.0, 0.0), *[(speed * np.cos(way), speed * np.sin(way)) for way in (0.0, pi / 4, pi / 2)]]
    for case, (east, north) in product(DEFAULT_CASES, winds):
        stepper = Stepper(
            system.cascade,
            system.nominal,
            system.timing,
            smooth_dynamics(system.vehicle),
            Trim(wind=Vec3(east, north, 0.0)),
            terms_of(system.cascade),
            straight_gains(asked, gains, case),
            array.NAMES,
        )
        state = settled(stepper, system, gains)
        a, b, c = numerical(stepper, state, gains)
        moving = np.abs(np.linalg.eigvals(a))
        assert np.sum(moving > 1.0 - 1e-6) <= 1 and moving.max(axis=0) < 1.0 + 1e-6
        worst.append(read_off(a, b, c, h))
    found = np.array(worst)
    return [found[:, 0].min(axis=0), found[:, 1].min(axis=0), found[:, 2].max(axis=0), found[:, 3].min(axis=0)]


def settled(stepper, system, gains):
    """State in which a flight starts in the trim: it must not move."""
    body = pack(Body, trim_of(system.vehicle, stepper.trim.wind).body[0].tolist())
    reference = stepper.reference()
    constants = system.cascade.prepare(pack(system.cascade.Gains, gains.tolist()), system.timing.control_period)
    noise, targets = pack(Noise, [0.0] * size(Noise)), pack(Targets, [0.0] * size(Targets))
    flight = stepper.loop.start(body, constants, system.nominal, reference, noise, targets, stepper.dynamics)
    state = np.array(flatten(stepper.state(*(getattr(flight, name) for name in stepper.state._fields))))
    clipped = ["excess" in name for name in paths(stepper.state)]
    following = np.where(clipped, 0.0, stepper.injected(state, gains, np.zeros(6))[: len(state)])
    np.testing.assert_allclose(following, np.where(clipped, 0.0, state), atol=1e-9)
    return following


@pytest.mark.slow
def test_same_bits_for_another_thread_count(ran, tmp_path):
    outcome, _ = ran
    alone, _ = searched(tmp_path / "alone", load_study(QUICKSTART, REQUIRED), threads=1)
    assert np.array_equal(alone.points, outcome.archive.points)
    assert np.array_equal(alone.requirements, outcome.archive.requirements)
    assert np.array_equal(alone.values, outcome.archive.values)


@pytest.mark.slow
def test_a_margin_that_nobody_can_have_screens_all_but_the_default(tmp_path):
    margin = {"quantity": "phase_margin", "min": 170.0}
    impossible = {"margin": [margin], "search.generations": 2, "search.population": 8}
    study = load_study(QUICKSTART, REQUIRED | impossible)
    found, warnings = searched(tmp_path / "none", study)
    assert found.flown.tolist() == [True] + [False] * (len(found.flown) - 1)
    assert any("phase_margin at least 170 deg was kept by 0 of 16 candidates" in text for text in warnings)
    assert np.isfinite(found.violations).all()


def test_a_target_that_is_missed_is_flown_and_counts(tmp_path):
    target = {"quantity": "phase_margin", "min": 170.0, "hard": False}
    few = {"margin": [target], "search.generations": 2, "search.population": 8}
    found, _ = searched(tmp_path / "soft", load_study(QUICKSTART, REQUIRED | few))
    assert found.flown.all()
    broken = found.violations[:, -1]
    assert np.all((broken > 0.0) & (broken <= LARGEST_VIOLATION))
    np.testing.assert_allclose(broken, 1.0 - found.requirements[:, -1] / 170.0, rtol=1e-12)
