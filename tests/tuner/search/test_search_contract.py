"""What every search keeps: it starts where it is told, follows from its seed alone, stays in the cube, survives anything."""

import os
import subprocess
import sys
import warnings
from math import pi
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import qmc

from plant.seeds import generator
from tests.tuner.search.search_runs import (
    CASES,
    LARGE_POPULATION,
    MORE_CASES,
    bowls,
    digests,
    run,
    run_generations,
    started,
    stepped,
)
from tuner.search.front import feasible_front
from tuner.search.loop import RevisableSearch
from tuner.search.names import ALGORITHMS
from tuner.search.registry import SEARCHES
from tuner.search.sobol import Sobol

ROOT = Path(__file__).parents[3]
every = pytest.mark.parametrize(("name", "objectives"), CASES)
every_and_more = pytest.mark.parametrize(("name", "objectives"), MORE_CASES)
# A model of each of four objectives takes a second and shows what two do; that it can be searched at all is asked of it too.
every_and_less = pytest.mark.parametrize(
    ("name", "objectives"),
    [pytest.param(*case, marks=pytest.mark.slow if case == ("gaussian_process", 4) else ()) for case in MORE_CASES],
)
# What uses what it is told, and what compares candidates only and measures no distance between them.
TOLD = [case for case in CASES if case[0] not in ("random", "sobol")]
RANKED = [case for case in CASES if case[0] in ("cmaes", "differential_evolution", "random", "sobol")]


@pytest.fixture
def other_process():
    """Runs in a process of its own and two threads of linear algebra, where this one has one."""
    names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
    environment = os.environ | dict.fromkeys(names, "2")
    command = [sys.executable, "-m", "tests.tuner.search.search_runs", "2"]
    with subprocess.Popen(command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True) as child:
        yield child
        child.kill()


def test_the_registry_has_what_the_names_promise():
    assert list(SEARCHES) == list(ALGORITHMS)


@every_and_more
def test_the_first_generation_is_the_one_given_and_all_are_as_large(name, objectives):
    first = started(4)
    first[1] = first[0]  # Two starting points may coincide.
    points = run(name, objectives, bowls(objectives), first=first)[0]
    assert np.array_equal(points[0], first)
    assert points.shape[1:] == first.shape
    assert np.all((points >= 0.0) & (points <= 1.0))


@every_and_less
def test_the_seed_alone_decides(name, objectives):
    # Many candidates break the constraints equally, and libraries decide ties by generators that they seed from the system.
    problem, first = stepped(objectives), started(4)
    np.random.seed(1)  # noqa: NPY002
    once = run(name, objectives, problem, first=first)[0]
    np.random.seed(2)  # noqa: NPY002
    again = run(name, objectives, problem, first=first)[0]
    other = run(name, objectives, problem, first=first, seed=2)[0]
    assert np.array_equal(once, again)
    assert not np.any(np.all(once[1:] == other[1:], axis=(1, 2)))


@every
def test_a_fresh_one_told_the_same_goes_on_the_same(name, objectives):
    problem, first = stepped(objectives), started(4)
    points, values, violations = run(name, objectives, problem, first=first, generations=5)
    resumed = SEARCHES[name](first, objectives, violations.shape[2], 1)
    replayed = run_generations(resumed, lambda given: recorded(given, points, values, violations), len(first), 4)
    assert np.array_equal(replayed[0], points[:4])
    assert np.array_equal(run_generations(resumed, problem, len(first), len(points) - 4)[0], points[4:])


def recorded(given, points, values, violations):
    """Return the values and violations on record of points that were evaluated before."""
    rows = {point.tobytes(): i for i, point in enumerate(points.reshape(-1, points.shape[-1]))}
    found = [rows[point.tobytes()] for point in given]
    return values.reshape(-1, values.shape[-1])[found], violations.reshape(-1, violations.shape[-1])[found]


@every
def test_the_callers_arrays_stay_as_they_are_and_may_be_reused(name, objectives):
    problem, first = stepped(objectives), started(4)
    expected = run(name, objectives, problem, first=first.copy(), generations=4)[0]
    search = SEARCHES[name](first, objectives, 2, 1)
    first[:] = -1.0
    expected = np.concatenate(expected)
    while len(expected):
        asked = search.ask()
        assert np.array_equal(asked, expected[: len(asked)])
        expected = expected[len(asked) :]
        values, violations = problem(asked)
        asked[:] = -1.0
        kept = values.copy(), violations.copy()
        search.tell(values, violations)
        assert np.array_equal(values, kept[0]) and np.array_equal(violations, kept[1])
        for mine in (values, violations):
            mine[:] = -1.0


@every_and_less
def test_units_and_origin_of_the_objectives_do_not_matter(name, objectives):
    # Powers of two and a grid: shifted and scaled without rounding, so the points must be the same bits.
    problem = bowls(objectives)
    scale, shift = 2.0 ** np.linspace(-40, 12, objectives).round(), np.linspace(16.0, -8.0, objectives)

    def moved(points):
        values, violations = problem(points)
        return (values + shift) * scale, violations

    assert np.array_equal(run(name, objectives, problem)[0], run(name, objectives, moved)[0])


@pytest.mark.parametrize(("name", "objectives"), RANKED)
def test_what_compares_only_follows_any_increasing_map(name, objectives):
    problem = stepped(objectives)

    def bent(points):
        values, violations = problem(points)
        return np.expm1(values) ** 3, violations

    assert np.array_equal(run(name, objectives, problem)[0], run(name, objectives, bent)[0])


@every
def test_units_of_the_constraints_do_not_matter(name, objectives):
    problem = stepped(objectives)

    def rescaled(points):
        values, violations = problem(points)
        return values, violations * [2.0**20, 2.0**-6]

    assert np.array_equal(run(name, objectives, problem)[0], run(name, objectives, rescaled)[0])


@pytest.mark.parametrize(("name", "objectives"), TOLD)
def test_constraints_are_heard(name, objectives):
    assert not np.array_equal(
        run(name, objectives, stepped(objectives))[0][1:], run(name, objectives, bowls(objectives))[0][1:]
    )


def hostile(kind, objectives):
    def problem(points):
        n, values = len(points), bowls(objectives)(points)[0]
        constant, kept, broken = np.ones((n, objectives)), np.zeros((n, 2)), np.ones((n, 2))
        failed = points[:, 0] < 0.75
        return {
            "constant": (constant, kept),
            "one constant": (np.concatenate([constant[:, :1], values[:, 1:]], axis=1), kept),
            "infeasible": (values, broken * (1.0 + points[:, :1])),
            "equally infeasible": (values, broken),
            "all failed": (constant * 1e300, broken * 1e300),
            "failed without constraints": (constant * 1e300, kept[:, :0]),
            "most failed": (np.where(failed[:, None], 1e15, values), kept[:, :0]),
            "one feasible": (values, broken * (np.arange(n) != 5)[:, None]),
        }[kind]

    return problem


HOSTILE = ["constant", "one constant", "infeasible", "equally infeasible", "all failed", "failed without constraints"]


@pytest.mark.parametrize("kind", [*HOSTILE, "most failed", "one feasible"])
@pytest.mark.parametrize("dimensions", [1, 5])
@every
def test_hostile_problems_are_survived(name, objectives, dimensions, kind):
    # Warnings are errors here, so this says too that nothing overflowed or was divided by zero on the way.
    generations = 4 if name == "gaussian_process" else 8  # A model's points cost most, and all that it met are in it.
    points = run(name, objectives, hostile(kind, objectives), dimensions, population=8, generations=generations)[0]
    assert points.shape == (generations, 8, dimensions)
    assert np.all((points >= 0.0) & (points <= 1.0))  # False for NaN too.
    # Nothing has collapsed. Two trials of differential evolution may be one in one dimension, of 210 that there are.
    assert all(len(np.unique(generation, axis=0)) >= 6 for generation in points)


@every
def test_warnings_of_the_rest_of_the_program_stay_on(name, objectives):
    before = list(warnings.filters)
    run(name, objectives, bowls(objectives), generations=4)
    assert warnings.filters == before


def ball(dimensions):
    """Volume of the unit ball, of three dimensions or more by its recursion."""
    return [1.0, 2.0][dimensions] if dimensions < 2 else 2.0 * pi / dimensions * ball(dimensions - 2)


@pytest.mark.parametrize("name", ["nsga2", "cmaes", "differential_evolution"])
def test_one_convex_objective_better_than_luck(name):
    # Of N points at random in six dimensions, one comes within r of the best with a chance of at most N V r^6. With r for one
    # in a million, a search that comes as near has not been lucky.
    dimensions, generations = 6, 40
    near = (1e-6 / (generations * LARGE_POPULATION * ball(dimensions))) ** (1 / dimensions)
    values = run(name, 1, bowls(1), dimensions, LARGE_POPULATION, generations)[1]
    assert values.min(axis=None) < near**2


@pytest.mark.parametrize("name", ["nsga2", "nsga3", "age_moea"])
def test_two_convex_objectives_better_than_luck(name):
    # The best of two bowls lie on the segment between their middles. Of N points at random, N times the volume of the tube of
    # radius r around it are expected there. With r for a half, ten or more, besides the default that stands on the segment,
    # have a chance of at most 0.5^10 / 10!.
    dimensions, generations = 6, 40
    ends, length = (0.25, 0.75), 0.5 * dimensions**0.5

    def expected(r):
        tube = length * ball(dimensions - 1) * r ** (dimensions - 1) + ball(dimensions) * r**dimensions
        return generations * LARGE_POPULATION * tube

    near = max(r for r in np.linspace(0.0, 1.0, 1001) if expected(r) <= 0.5)
    points = run(name, 2, bowls(2), dimensions, LARGE_POPULATION, generations)[0].reshape(-1, dimensions)
    along = np.clip(points.mean(axis=1), *ends)
    inside = np.linalg.norm(points - along[:, None], axis=1) <= near
    assert np.sum(inside) >= 11
    # And not all in one place: over a quarter of the segment at least.
    assert np.ptp(along[inside]) > 0.125


def srinivas(points, square=225.0):
    """N. Srinivas, K. Deb, Evolutionary Computation 2(3):221-248, 1994: best at x = -2.5, y from 2.5 to sqrt(218.75)."""
    x, y = (40.0 * points - 20.0).T
    values = np.stack([2.0 + (x - 2.0) ** 2 + (y - 1.0) ** 2, 9.0 * x - (y - 1.0) ** 2], axis=1)
    return values, np.maximum(np.stack([x**2 + y**2 - square, x - 3.0 * y + 10.0], axis=1), 0.0)


@pytest.mark.parametrize("name", ["nsga2", "nsga3", "age_moea"])
def test_a_known_front_between_constraints(name):
    points, values, violations = (
        part.reshape(-1, 2) for part in run(name, 2, srinivas, 2, LARGE_POPULATION, generations=40)
    )
    front = feasible_front(values, violations)
    x, y = (40.0 * points[front] - 20.0).T
    # Within 0.1 of the line lies 0.0015 of the square: 1.6 of 1040 points at random. Fifteen have a chance of at most
    # 1.6^15 / 15!, one in a billion.
    good = np.abs(x + 2.5) < 0.1
    assert np.sum(good) >= 15
    assert y[good].min(axis=0) < 4.0 and y[good].max(axis=0) > 13.0


SLOPE = np.array([1.0, 2.0, 0.5, 1.5])


def halfspace(points):
    """Squared length where SLOPE.x is at least 1: best at SLOPE / |SLOPE|^2, with the value 1 / |SLOPE|^2."""
    return np.square(points).sum(axis=1)[:, None], np.maximum(1.0 - points @ SLOPE, 0.0)[:, None]


@pytest.mark.parametrize("name", ["cmaes", "differential_evolution"])
def test_a_known_best_on_a_constraint(name):
    # Values up to e above the best fill a cap of the ball, within a cylinder of radius sqrt(e) and height h. With e for one
    # in a hundred, three seeds at random are that near with a chance of one in a million.
    best, generations, candidates = 1.0 / (SLOPE @ SLOPE), 40, 40 * LARGE_POPULATION
    cylinder = {e: ball(3) * e**1.5 * ((best + e) ** 0.5 - best**0.5) for e in np.geomspace(1e-6, 1.0, 601)}
    near = max(e for e, volume in cylinder.items() if candidates * volume <= 0.01)
    for seed in range(3):
        first = started(4, LARGE_POPULATION, seed)
        _, values, violations = run(name, 1, halfspace, generations=generations, first=first, seed=seed)
        feasible = values[..., 0][violations[..., 0] <= 0.0]
        assert best - 1e-12 < feasible.min(axis=0) < best + near


# Share of late candidates that keep a limit; where a population stays at the former one, 0 to 0.44 of them do.
KEEPING = 0.55


def toward(points, limit):
    """`halfspace` with another limit: best value limit^2 / |SLOPE|^2."""
    return np.square(points).sum(axis=1)[:, None], (limit - points @ SLOPE)[:, None]


@pytest.mark.parametrize("name", ["nsga2", "cmaes", "differential_evolution"])
def test_a_search_retold_of_another_limit_ends_at_the_best_behind_it(name):
    # By 20 generations the first limit, 1, has drawn the search to it; all candidates there break the second one, 1.5.
    best = 1.5**2 / (SLOPE @ SLOPE)
    search = SEARCHES[name](started(4, LARGE_POPULATION), 1, 1, 1)
    assert isinstance(search, RevisableSearch)
    before = np.concatenate(run_generations(search, lambda points: toward(points, 1.0), LARGE_POPULATION, 20)[0])
    drawn = before[-LARGE_POPULATION:]
    assert np.median(drawn @ SLOPE) < 1.25
    search.retell(*toward(before, 1.5))
    values, violations = (
        part.ravel() for part in run_generations(search, lambda points: toward(points, 1.5), LARGE_POPULATION, 40)[1:]
    )
    assert best - 1e-12 < values[violations <= 0.0].min() < 1.05 * best
    assert np.mean(violations[-5 * LARGE_POPULATION :] <= 0.0) > KEEPING


@pytest.mark.parametrize("name", ["nsga2", "nsga3", "age_moea"])
def test_a_front_retold_of_another_limit_ends_behind_it(name):
    # The first circle is left by x = -2.5 at y = 14.8, the second one at 10.3; below both the front begins at 2.5.
    search = SEARCHES[name](started(2, LARGE_POPULATION), 2, 2, 1)
    assert isinstance(search, RevisableSearch)
    before = np.concatenate(run_generations(search, srinivas, LARGE_POPULATION, 20)[0])
    search.retell(*srinivas(before, square=112.5))
    points, values, violations = (
        part.reshape(-1, 2)
        for part in run_generations(search, lambda points: srinivas(points, square=112.5), LARGE_POPULATION, 20)
    )
    x, y = (40.0 * points[feasible_front(values, violations)] - 20.0).T
    good = np.abs(x + 2.5) < 0.1
    assert np.sum(good) >= 10
    assert y[good].min() < 4.0 and 9.3 < y[good].max() < 10.4
    assert np.mean(np.all(violations[-5 * LARGE_POPULATION :] <= 0.0, axis=1)) > KEEPING


def test_cmaes_begins_elsewhere_when_it_has_converged():
    def sphere(points):
        return np.square(points - 0.3).sum(axis=1)[:, None], np.zeros((len(points), 0))

    points = run("cmaes", 1, sphere, 2, population=16, generations=200)[0]
    width = np.ptp(points, axis=1).max(axis=1)
    converged = int(np.argmin(width))
    assert width[converged] < 1e-8
    assert width[converged:].max(axis=0) > 0.5


def test_differential_evolution_moves_over_a_plateau_as_its_authors_say():
    # Every trial is as good as the point that it is for and takes its place, so the next trial has what it does not take from
    # the mutant from there: a variable with a chance of 0.1, unless it is the one in five that is always the mutant's.
    points = run("differential_evolution", 1, hostile("constant", 1), 5, LARGE_POPULATION, generations=100)[0]
    kept = points[1:] == points[:-1]
    chance = 0.1 * 0.8
    # The variables of a trial are next to independent; five standard deviations of a share of so many.
    assert abs(kept.mean(axis=None) - chance) < 5 * (chance * (1 - chance) / kept.size) ** 0.5
    assert not np.any(np.all(kept, axis=2))


def test_random_is_uniform():
    points = run("random", 1, bowls(1), 3, LARGE_POPULATION, generations=101)[0][1:].reshape(-1, 3)
    # Each of 64 boxes holds n / 64 of n points, give or take the binomial standard deviation; chi squared of 63 degrees of
    # freedom has mean 63 and standard deviation sqrt(126).
    counts = np.bincount(np.ravel_multi_index((points.T * 4).astype(int), (4, 4, 4)), minlength=64)
    chi = np.square(counts - len(points) / 64).sum(axis=0) / (len(points) / 64)
    assert abs(chi - 63) < 5 * 126**0.5


@pytest.mark.parametrize("dimensions", [1, 2, 18])
def test_sobol_points_are_those_of_scipy_to_the_last_bit(dimensions):
    drawn = Sobol(dimensions, generator(3, "test", dimensions))
    wanted = qmc.Sobol(dimensions, scramble=True, rng=generator(3, "test", dimensions))
    for count in (1, 0, 6, 64, 17):
        assert np.array_equal(drawn.random(count), wanted.random(count))


@pytest.mark.slow
def test_sobol_is_a_net():
    points = run("sobol", 1, bowls(1), 2, population=16, generations=17)[0][1:].reshape(-1, 2)
    # 256 points of the sequence in two dimensions: one in each box of area 1 / 256 with sides that are powers of two.
    for k in range(9):
        boxes = np.floor(points * [2.0**k, 2.0 ** (8 - k)]).astype(int)
        assert len(np.unique(boxes, axis=0)) == 256
    # In any dimension each variable takes every stratum once, whatever the population: 16 times 26 points, the first 256.
    wide = run("sobol", 1, bowls(1), 9, LARGE_POPULATION, generations=17)[0][1:].reshape(-1, 9)[:256]
    assert all(len(np.unique(column)) == 256 for column in np.floor(wide.T * 256))


@pytest.mark.slow
def test_neither_another_process_nor_its_threads_matter(other_process):
    there = other_process.communicate(timeout=120)[0].splitlines()
    assert other_process.returncode == 0
    assert len(there) == len(CASES)
    assert there == digests(1)
