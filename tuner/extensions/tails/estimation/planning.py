"""The plan of a tail: which method, which ladders, how many states, from a pilot on a stream of its own."""

from dataclasses import dataclass, field
from math import sqrt
from typing import NamedTuple

import numpy as np

from plant.seeds import generator
from tuner.extensions.tails.estimation.hidden_modes import (
    MAX_DIMENSIONS,
    Sector,
    SectorLimit,
    divide,
    most_evaluations,
)
from tuner.extensions.tails.estimation.intervals import FIRST, student_quantile
from tuner.extensions.tails.estimation.limit_function import Array, LimitFunction, Method
from tuner.extensions.tails.estimation.splitting import CHAIN, FRACTION, Ascent, Ladder, climb, run_together

PILOT_CHAINS = 50
"""Chains of an ascent to a mode or a sector: with 30, some sectors got so few states that an estimate took ten times the
replicas.
"""
MIN_CHAINS = 25
"""Chains of a replica's ladders together, at least."""
CRUDE_FROM = 0.004
"""Probability above which crude Monte Carlo costs less, at any width: (1 - p) / p against `SPREAD` ln(p)^2."""
SPREAD = 8.0
"""Cost of splitting: squared coefficient of variation times evaluations, over ln(p)^2: first passages took 7 to 8, pilot
included.
"""
FAILURES = 8
"""Failures of a mode, at most, from which its design point may be sought."""
PILOT_DEPTH = 30.0
"""Factor below the smallest requested probability at which a pilot ends; with its few states it may be off by 3."""
MEMORY = 100e6
"""Bytes that the states of replicas may take."""
VECTORS = 11
"""Number of normal vectors per chain at most: states, their moves, and survivors of two levels, of which one is being
gathered.
"""


class Request(NamedTuple):
    """The estimate asked for.

    Attributes:
        relative_width: width of the interval over the probability: 0.5 is about a quarter to either side.
        smallest: probability that matters.
        most_evaluations: rows of the limit function, pilot included.
        confidence: confidence of the intervals.
        method: None for the one that costs less.
    """

    relative_width: float = 0.5
    smallest: float = 1e-6
    most_evaluations: int = 10_000_000
    confidence: float = 0.95
    method: Method | None = None


@dataclass(frozen=True)
class Plan:
    """All that replicas need but their streams; a function of limit function, request and seed.

    Attributes:
        method: method of the replicas.
        ladders: ladders of splitting, in columns of the sectors' limit function.
        sectors: sectors of modes that hide others.
        curve: levels at which the largest demand is counted; the last is 1.
        failures: some (k, d) of each mode that was reached.
        is_stalled: whether no ladder reached the event, and one of them for want of anything nearer to it.
        probability: probability of the event, roughly.
        independent: first rows of each ascent, drawn independently; none fails by a mode that was not reached.
        evaluations: rows of the pilot.
    """

    method: Method
    ladders: tuple[Ladder, ...] = ()
    sectors: tuple[Sector, ...] = ()
    curve: Array = field(default_factory=lambda: np.ones(1))
    failures: dict[int, Array] = field(default_factory=dict[int, Array])
    is_stalled: bool = False
    probability: float = 0.0
    independent: int = 0
    evaluations: int = 0


@dataclass
class _CountedLimit:
    """A limit function that counts its rows."""

    limit: LimitFunction
    evaluations: int = 0

    @property
    def dimension(self) -> int:
        return self.limit.dimension

    @property
    def modes(self) -> tuple[str, ...]:
        return self.limit.modes

    def values(self, normals: Array) -> Array:
        self.evaluations += len(normals)
        return self.limit.values(normals)


def expected_evaluations(probability: float, relative_width: float, method: Method) -> int:
    """Return the rows that an estimate takes, pilot included, at 95 %."""
    per_variance = SPREAD * np.log(probability) ** 2 if method is Method.SPLITTING else 1.0 / probability - 1.0
    rows = (2.0 * 1.96 / relative_width) ** 2 * per_variance
    if method is Method.SPLITTING:
        # However wide the interval may be.
        rows = max(rows, FIRST * MIN_CHAINS * CHAIN * np.log(probability) / np.log(FRACTION))
    return int(np.ceil(rows))


def choose_method(probability: float) -> Method:
    """Return the method that costs less."""
    return Method.CRUDE if probability >= CRUDE_FROM else Method.SPLITTING


def pilot_evaluations(limit: LimitFunction, smallest: float) -> int:
    """Return the most rows that a pilot takes; most take a third."""
    levels = int(np.ceil(np.log(smallest / PILOT_DEPTH) / np.log(FRACTION))) + 1
    rows = PILOT_CHAINS * CHAIN * levels
    if limit.dimension <= MAX_DIMENSIONS:
        rows += 2 * PILOT_CHAINS * CHAIN * levels + most_evaluations(limit.dimension)
    return rows * len(limit.modes)


def plan_tail(limit: LimitFunction, seed: int, request: Request) -> Plan:
    """Return the plan of a tail: modes climbed, hidden modes looked for, states dealt out."""
    if limit.dimension == 0:
        return Plan(Method.EVALUATION)
    if request.method is Method.CRUDE or request.most_evaluations < 1.5 * pilot_evaluations(limit, request.smallest):
        return Plan(Method.CRUDE, curve=np.linspace(0.1, 1.0, 10))
    counted = _CountedLimit(limit)
    chains = min(PILOT_CHAINS, most_chains(limit.dimension))
    ascents, sectors = _climb_all(counted, seed, chains, request.smallest / PILOT_DEPTH)
    reached = [ascent for ascent in ascents if ascent.ladder.target == 1.0]
    probability = min(sum(ascent.probability for ascent in reached), 1.0)
    method = request.method or choose_method(probability)
    return Plan(
        method=method,
        ladders=_sized(reached or [a for a in ascents if a.ladder.target > -np.inf], request, limit.dimension),
        sectors=sectors,
        curve=_curve(ascents),
        failures=_failures(limit, sectors, reached),
        is_stalled=not reached and any(ascent.is_stalled for ascent in ascents),
        probability=probability,
        independent=chains * CHAIN,
        evaluations=counted.evaluations,
    )


def most_chains(dimension: int) -> int:
    """Return the chains whose states fit into `MEMORY`."""
    return max(int(MEMORY / (8 * VECTORS * dimension)), 1)


def replicas_at_once(plan: Plan, dimension: int, most: int) -> int:
    """Return the number of replicas whose states fit into `MEMORY`."""
    largest = max((ladder.chains for ladder in plan.ladders), default=1)
    return max(min(most_chains(dimension) // largest, most), 1)


def _climb_all(
    limit: LimitFunction, seed: int, chains: int, smallest: float
) -> tuple[list[Ascent], tuple[Sector, ...]]:
    """Return an ascent to each mode or sector."""
    ascents, sectors = list[Ascent](), list[Sector]()
    for mode in range(len(limit.modes)):
        rng = generator(seed, "tail/pilot", mode)
        [ascent] = run_together(limit, [climb(mode, limit.dimension, chains, smallest, rng)])
        is_rare = ascent.probability < CRUDE_FROM and np.isfinite(ascent.ladder.target)
        parts = divide(limit, ascent, chains, smallest, rng) if is_rare and limit.dimension <= MAX_DIMENSIONS else ()
        for sector, part in parts:
            column = len(limit.modes) + len(sectors)
            sectors.append(sector)
            ascents.append(part._replace(ladder=part.ladder._replace(mode=column)))
        if not parts:
            ascents.append(ascent)
    return ascents, tuple(sectors)


def _sized(ascents: list[Ascent], request: Request, dimension: int) -> tuple[Ladder, ...]:
    """Return ladders with chains for about `FIRST` replicas.

    As many as make these as narrow as asked for, dealt out in proportion to the probabilities, because then all modes cost as
    much as one, but at least a fifth of an equal part each, because a pilot is rough.
    """
    if not ascents:
        return ()
    probabilities = np.array([ascent.probability for ascent in ascents])
    variation = sqrt(FIRST) * request.relative_width / (2.0 * student_quantile(request.confidence, FIRST))
    total = float(
        np.clip(0.9 * np.log(1.0 / min(np.sum(probabilities), 0.9)) / np.log1p(variation**2), MIN_CHAINS, 1000.0)
    )
    parts = np.maximum(probabilities / np.sum(probabilities), 0.2 / len(ascents))
    chains = np.clip(np.ceil(total * parts).astype(int), 3, most_chains(dimension))
    return tuple(ascent.ladder._replace(chains=int(n)) for ascent, n in zip(ascents, chains, strict=True))


def _curve(ascents: list[Ascent]) -> Array:
    """Return the levels of all ladders and 1, at most some 20."""
    levels = sorted({level for ascent in ascents for level in ascent.ladder.levels if 0.0 < level < 1.0})
    return np.array([*levels[:: len(levels) // 20 + 1], 1.0])


def _failures(limit: LimitFunction, sectors: tuple[Sector, ...], ascents: list[Ascent]) -> dict[int, Array]:
    """Return some failures of each mode; of several sectors those of the most probable one."""
    columns = [*range(len(limit.modes)), *(sector.mode for sector in sectors)]
    ascents = sorted(ascents, key=lambda ascent: ascent.probability)
    return {columns[ascent.ladder.mode]: ascent.some_states(FAILURES) for ascent in ascents}


def limit_of(limit: LimitFunction, plan: Plan) -> LimitFunction:
    """Return the limit function whose columns the ladders name."""
    return SectorLimit(limit, plan.sectors) if plan.sectors else limit
