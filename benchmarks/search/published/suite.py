"""The problems of the suite by name.

Beside `real_world`, pymoo's classes (J. Blank, K. Deb, "pymoo: Multi-objective optimization in Python", IEEE Access
8:89497-89509, 2020), whose sources are: zdt: E. Zitzler, K. Deb, L. Thiele, 2000; dtlz: K. Deb, L. Thiele, M. Laumanns, E.
Zitzler, 2002; ctp: K. Deb, A. Pratap, T. Meyarivan, 2001; mw: Z. Ma, Y. Wang, 2019; bnh: T. T. Binh, U. Korn, 1997; osy: A.
Osyczka, S. Kundu, 1995; tnk: M. Tanaka, H. Watanabe, Y. Furukawa, T. Tanino, 1995; welded_beam: K. Deb, 2000; truss2d: K.
Deb, 2001; pressure_vessel: E. Sandgren, 1990; g6, g7, g9: Z. Michalewicz, M. Schoenauer, 1996, with the optima of J. J. Liang
et al., CEC 2006; rastrigin: L. A. Rastrigin, 1974.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from pymoo.core.problem import Problem
from pymoo.problems.many.dtlz import DTLZ2, DTLZ7
from pymoo.problems.multi import BNH, MW1, MW2, MW3, MW7, OSY, TNK, ZDT1, ZDT3, ZDT6, Truss2D, WeldedBeam
from pymoo.problems.multi import ctp as ctp_module
from pymoo.problems.single import G6, G7, G9, PressureVessel, Rastrigin
from pymoo.util.ref_dirs import get_reference_directions

from benchmarks.search.published import real_world
from benchmarks.search.published.problem import Array, PublishedProblem
from tuner.search.front import non_dominated

# Standard deviation of the noise of the noisy problems.
NOISE = 0.03
# Variables of dtlz and mw, whose number is free: with 15 no search finds a feasible point of mw1 to mw3 in 300 evaluations.
FEW = 6


def _real(function: Callable[[Array], tuple[Array, Array]], lower: list[float], upper: list[float]) -> PublishedProblem:
    """Return a problem of `real_world`."""
    values, constraints = function(np.array([lower, upper]) * 0.5 + 0.5)
    return PublishedProblem(function, np.array(lower), np.array(upper), values.shape[1], constraints.shape[1])


def _library(
    problem: Problem, front: Callable[[], Array] | None = None, optimum: float | None = None
) -> PublishedProblem:
    """Return a problem of pymoo."""

    def evaluate(x: Array) -> tuple[Array, Array]:
        result = problem.evaluate(x, return_values_of=["F", "G"])
        return result[0], result[1]

    lower, upper = np.array(problem.xl, dtype=float), np.array(problem.xu, dtype=float)
    return PublishedProblem(evaluate, lower, upper, problem.n_obj, problem.n_ieq_constr, front, optimum)


def _line() -> Array:
    """Return points (k, 2) evenly spaced in the first objective, the second of which pymoo fills in."""
    return np.column_stack([np.linspace(0.0, 1.0, 1000), np.zeros(1000)])


def _sphere_front() -> Array:
    """Return the front of dtlz2 with three objectives: an octant of the unit sphere."""
    directions = get_reference_directions("das-dennis", 3, n_partitions=150)
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def _dtlz7_front() -> Array:
    """Return the front of dtlz7 with three objectives, from a grid of the first two."""
    first, second = (axis.ravel() for axis in np.meshgrid(*[np.linspace(0.0, 1.0, 200)] * 2))
    bumps = sum(value * (1.0 + np.sin(3.0 * np.pi * value)) for value in (first, second))
    values = np.column_stack([first, second, 6.0 - bumps])
    return values[non_dominated(values)]


CTP = {f"ctp{i}": _library(getattr(ctp_module, f"CTP{i}")()) for i in range(1, 9)}
BEAM = ([0.125, 0.1, 0.1, 0.125], [5.0, 10.0, 10.0, 5.0])
TRUSS = ([1e-5, 1e-5, 1.0], [100.0, 100.0, 3.0])
BRAKE = ([55.0, 75.0, 1000.0, 11.0], [80.0, 110.0, 3000.0, 20.0])
ROOT = 2.0**0.5
EXACT: dict[str, PublishedProblem] = {
    "RE21": _real(real_world.four_bar_truss, [1.0, ROOT, ROOT, 1.0], [3.0] * 4),
    "RE22": _real(real_world.reinforced_concrete_beam, [0.2, 0.0, 0.0], [15.0, 20.0, 40.0]),
    "RE23": _real(real_world.pressure_vessel_violation, [1.0, 1.0, 10.0, 10.0], [100.0, 100.0, 200.0, 240.0]),
    "RE24": _real(real_world.hatch_cover, [0.5, 0.5], [4.0, 50.0]),
    "RE31": _real(real_world.two_bar_truss_violation, *TRUSS),
    "RE33": _real(real_world.disc_brake_violation, *BRAKE),
    "RE34": _real(real_world.crashworthiness, [1.0] * 5, [3.0] * 5),
    "RE36": _real(real_world.gear_train, [12.0] * 4, [60.0] * 4),
    "RE37": _real(real_world.rocket_injector, [0.0] * 4, [1.0] * 4),
    "CRE21": _real(real_world.two_bar_truss, *TRUSS),
    "CRE22": _real(real_world.welded_beam, *BEAM),
    "CRE23": _real(real_world.disc_brake, *BRAKE),
    "CRE24": _real(
        real_world.speed_reducer, [2.6, 0.7, 17.0, 7.3, 7.3, 2.9, 5.0], [3.6, 0.8, 28.0, 8.3, 8.3, 3.9, 5.5]
    ),
    "CRE31": _real(
        real_world.side_impact, [0.5, 0.45, 0.5, 0.5, 0.875, 0.4, 0.4], [1.5, 1.35, 1.5, 1.5, 2.625, 1.2, 1.2]
    ),
    "bnh": _library(BNH(), front=lambda: np.asarray(BNH().pareto_front(n_points=1000))),
    "osy": _library(OSY()),
    "tnk": _library(TNK()),
    **CTP,
    "mw1": _library(MW1(n_var=FEW), front=lambda: np.asarray(MW1(n_var=FEW).pareto_front(ref_dirs=_line()))),
    "mw2": _library(MW2(n_var=FEW), front=lambda: np.asarray(MW2(n_var=FEW).pareto_front(ref_dirs=_line()))),
    "mw3": _library(MW3(n_var=FEW), front=lambda: np.asarray(MW3(n_var=FEW).pareto_front(ref_dirs=_line()))),
    "mw7": _library(MW7(n_var=FEW)),
    "zdt1": _library(ZDT1(n_var=10), front=lambda: np.asarray(ZDT1(n_var=10).pareto_front(n_pareto_points=1000))),
    "zdt1_30": _library(ZDT1(), front=lambda: np.asarray(ZDT1().pareto_front(n_pareto_points=1000))),
    "zdt3": _library(ZDT3(n_var=10), front=lambda: np.asarray(ZDT3().pareto_front(n_points=1000, flatten=True))),
    "zdt6": _library(ZDT6(), front=lambda: np.asarray(ZDT6().pareto_front(n_pareto_points=1000))),
    "dtlz2": _library(DTLZ2(n_var=FEW, n_obj=3), front=_sphere_front),
    "dtlz7": _library(DTLZ7(n_var=FEW, n_obj=3), front=_dtlz7_front),
    "welded_beam": _library(WeldedBeam()),
    "truss2d": _library(Truss2D(), front=lambda: np.asarray(Truss2D().pareto_front())),
    "pressure_vessel": _library(PressureVessel(), optimum=5885.3327736),
    "g6": _library(G6(), optimum=-6961.8138756),
    "g7": _library(G7(), optimum=24.3062090682),
    "g9": _library(G9(), optimum=680.6300573744),
    # The minimum lies off the center of the cube, which some searches try first.
    "rastrigin5": replace(_library(Rastrigin(n_var=5), optimum=0.0), lower=np.full(5, -4.37), upper=np.full(5, 5.63)),
}
SUITE = EXACT | {
    f"{name}_noisy": replace(EXACT[name], noise=NOISE, reference=name) for name in ("RE21", "RE33", "welded_beam")
}
