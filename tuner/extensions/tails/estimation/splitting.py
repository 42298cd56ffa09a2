"""Multilevel splitting with fixed levels and waste-free chains: unbiased estimates of small probabilities.

The event is reached over levels of the demand over capacity, each about `FRACTION` as probable as the one before. Of the N states
of a level those that reach the next one give M seeds, and each seed starts a chain of N / M states that stays above it; all of
these are the states of that level. The product of the fractions that reach is an unbiased estimate however slowly chains
mix, as long as levels, steps and numbers are fixed beforehand: a pilot on a stream of its own fixes them.

- S.-K. Au, J. L. Beck, "Estimation of small failure probabilities in high dimensions by subset simulation", Probabilistic
  Engineering Mechanics 16(4):263-277, 2001: levels and fractions.
- I. Papaioannou, W. Betz, K. Zwirglmaier, D. Straub, "MCMC algorithms for subset simulation", Probabilistic Engineering
  Mechanics 41:89-103, 2015: the move a u + sqrt(1 - a^2) w, whose acceptance does not fall with the dimension.
- H.-D. Dau, N. Chopin, "Waste-free sequential Monte Carlo", Journal of the Royal Statistical Society B 84(1):114-148, 2022:
  M seeds, all states of their chains, unbiased. Seeds are drawn by residual resampling, each survivor as often as another.

Several modes have a ladder each, so that none is lost behind a nearer one. A failure that lies on K ladders counts 1 / K on
each: R. M. Karp, M. Luby, "Monte-Carlo algorithms for enumeration and reliability problems", FOCS 1983.
"""

from collections.abc import Callable, Generator, Sequence
from functools import partial
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from tuner.extensions.tails.estimation.limit_function import Array, LimitFunction, Replica

FRACTION = 0.15
"""Fraction of states that reach the next level: on first passages 0.1 to 0.25 cost the same within 15 %."""
ACCEPTANCE = 0.35
"""Acceptance of moves, for which the pilot sets their size: 0.25 costs 1.3 times and 0.55 twice as much."""
CHAIN = 10
"""States of a chain: 5 to 40 at the same number of states cost the same within 15 %."""

Result = TypeVar("Result")
Sampler = Generator[Array, Array, Result]
"""Yields normals (n, d), is sent their demands over capacity (n, m), and returns a result."""


class Ladder(NamedTuple):
    """Levels to one mode of failure and how to move between them.

    Attributes:
        mode: column of the limit function's values.
        levels: levels of demand over capacity, increasing, below `target`.
        steps: size sqrt(1 - a^2) of the moves above each level.
        target: demand whose probability is estimated: 1, or less where the pilot came no further.
        chains: number of seeds of a level; `CHAIN` states come of each.
    """

    mode: int
    levels: tuple[float, ...]
    steps: tuple[float, ...]
    target: float
    chains: int

    def threshold(self, place: int) -> "Threshold":
        """Return the level that seeds must reach; of the target none are needed."""
        level = self.levels[place] if place < len(self.levels) else np.inf
        return lambda _: level


class Ascent(NamedTuple):
    """A pilot's ladder and the states with which it ended.

    Attributes:
        ladder: with its target at 1 or at the last level reached.
        probability: rough estimate for the target.
        reached: probability of each level.
        states: states that reach the target (n, d).
        is_stalled: whether no state lay above the target, although that is not yet rare.
    """

    ladder: Ladder
    probability: float
    reached: tuple[float, ...]
    states: Array
    is_stalled: bool

    def some_states(self, count: int) -> Array:
        """Return about a number of states, of different chains."""
        return self.states[:: max(len(self.states) // count, 1)][:count].copy()

    def probability_at(self, level: float) -> float:
        """Return the probability of a level, its logarithm interpolated."""
        levels = (*self.ladder.levels, self.ladder.target)
        logs = np.log((*self.reached, self.probability))
        return float(np.exp(np.interp(level, levels, logs)))


class Population(NamedTuple):
    """States (n, d) and their demands over capacity (n, m)."""

    states: Array
    values: Array

    def reaching(self, mode: int, level: float) -> "Population":
        """Return the part whose demand of a mode reaches a level."""
        reach = self.values[:, mode] >= level
        return Population(self.states[reach], self.values[reach])


class Sample(NamedTuple):
    """Demands above a level, and the states that reach the next one.

    Demands over capacity are of all states (N, m).

    Vectors may have 40,000 numbers, so no others are held.
    """

    values: Array
    survivors: Population


Threshold = Callable[[Array], float]
"""Level that states must reach to be held, of the demands of a mode so far."""


def run_together(limit: LimitFunction, samplers: Sequence[Sampler[Result]]) -> list[Result]:
    """Return the results of samplers whose rows are evaluated side by side."""
    results: dict[int, Result] = {}
    rows = {i: next(sampler) for i, sampler in enumerate(samplers)}
    while rows:
        values = evaluate(limit, next(iter(rows.values())) if len(rows) == 1 else np.concatenate(list(rows.values())))
        ends = np.cumsum([len(part) for part in rows.values()])
        for i, part in zip(list(rows), np.split(values, ends[:-1]), strict=True):
            try:
                rows[i] = samplers[i].send(part)
            except StopIteration as end:
                results[i] = end.value
                del rows[i]
    return [results[i] for i in range(len(samplers))]


def evaluate(limit: LimitFunction, normals: Array) -> Array:
    """Return demand over capacity (n, m) of normals (n, d); infinite where there is no value."""
    return np.nan_to_num(limit.values(normals), nan=np.inf, posinf=np.inf, neginf=-np.inf)


def climb(mode: int, dimension: int, chains: int, smallest: float, rng: np.random.Generator) -> Sampler[Ascent]:
    """Return levels and step sizes, each from the states before.

    Args:
        mode: column of the limit function's values.
        dimension: dimension of the normals.
        chains: number of seeds of a level.
        smallest: probability below which the climb ends.
        rng: source of random numbers of the pilot.
    """
    levels, steps, reached = [-np.inf], [0.8], [1.0]
    largest = partial(_kth_largest, max(int(FRACTION * chains * CHAIN), 1))
    sample = yield from _draw(dimension, chains, mode, largest, rng)
    while True:
        values = sample.values[:, mode]
        level = next_level(values, levels[-1])
        if level is None or level >= 1.0 or reached[-1] < smallest:
            break
        reached.append(reached[-1] * float(np.mean(values >= level)))
        seeds = _seeds(sample.survivors.reaching(mode, level), chains, rng)
        sample, step = yield from _tune(mode, level, seeds, steps[-1], largest, rng)
        levels.append(level)
        steps.append(step)
    states = sample.survivors.reaching(mode, 1.0).states
    if len(states):
        ladder = Ladder(mode, tuple(levels[1:]), tuple(steps[1:]), 1.0, chains)
        probability = reached[-1] * float(np.mean(values >= 1.0))
        return Ascent(ladder, probability, tuple(reached[1:]), states, is_stalled=False)
    ladder = Ladder(mode, tuple(levels[1:-1]), tuple(steps[1:-1]), levels[-1], chains)
    return Ascent(ladder, reached[-1], tuple(reached[1:-1]), sample.survivors.states, level is None)


def _kth_largest(k: int, values: Array) -> float:
    return float(np.partition(values, -k)[-k]) if len(values) >= k else -np.inf


def next_level(values: Array, level: float) -> float | None:
    """Return the level that `FRACTION` of the values reach; None above all."""
    above = values[values > level]
    if not len(above):
        return None
    quantile = np.sort(values)[-max(int(FRACTION * len(values)), 1)]
    # Where values are tied, the next that is larger.
    return float(max(quantile, np.min(above)))


def _draw(dimension: int, chains: int, mode: int, threshold: Threshold, rng: np.random.Generator) -> Sampler[Sample]:
    """Return independent states, drawn in `CHAIN` parts."""
    sample = None
    for _ in range(CHAIN):
        states = rng.standard_normal((chains, dimension))
        values = yield states
        sample = _joined(sample, Population(states, values), mode, threshold)
    assert sample is not None
    return sample


def _joined(
    sample: Sample | None, part: Population, mode: int, threshold: Threshold, most: int | None = None
) -> Sample:
    """Return the sample with one part more.

    Args:
        sample: so far.
        part: part that is added.
        mode: column of the demands.
        threshold: threshold that survivors reach.
        most: survivors that are held of either; ties beyond are left out.
    """
    parts = [part] if sample is None else [sample.survivors, part]
    values = part.values if sample is None else np.concatenate([sample.values, part.values])
    level = threshold(values[:, mode])
    reaching = [_rows_reaching(level, each.values[:, mode], most) for each in parts]
    # Written into place, for a copy of each part beside the whole would be half of all memory.
    states, end = np.empty((sum(map(len, reaching)), part.states.shape[1])), 0
    for each, rows in zip(parts, reaching, strict=True):
        np.take(each.states, rows, axis=0, out=states[end : end + len(rows)], mode="clip")
        end += len(rows)
    survivors = np.concatenate([each.values[rows] for each, rows in zip(parts, reaching, strict=True)])
    return Sample(values, Population(states, survivors))


def _rows_reaching(level: float, values: Array, most: int | None) -> NDArray[np.intp]:
    """Return the places of values that reach a level, `most` with ties."""
    rows = np.flatnonzero(values >= level)
    if most is None or len(rows) <= most:
        return rows
    ties = rows[values[rows] == level]
    return np.setdiff1d(rows, ties[-(len(rows) - most) :])


def _seeds(survivors: Population, count: int, rng: np.random.Generator) -> Population:
    """Return `count` survivors, each as often as any other or once more (residual resampling)."""
    times, rest = divmod(count, len(survivors.states))
    every = np.arange(len(survivors.states))
    chosen = np.concatenate([np.tile(every, times), rng.permutation(every)[:rest]])
    return Population(survivors.states[chosen], survivors.values[chosen])


def _move(
    mode: int, level: float, population: Population, step: float, rng: np.random.Generator
) -> Sampler[tuple[Population, float]]:
    """Return the population after a move and the acceptance."""
    # In place, for vectors may have 40,000 numbers.
    states = rng.standard_normal(population.states.shape)
    states *= step
    states += np.sqrt(1.0 - step * step) * population.states
    values = yield states
    falls = values[:, mode] < level
    states[falls] = population.states[falls]
    return Population(states, np.where(falls[:, None], population.values, values)), float(np.mean(~falls))


def _tune(
    mode: int, level: float, seeds: Population, step: float, threshold: Threshold, rng: np.random.Generator
) -> Sampler[tuple[Sample, float]]:
    """Return chains and the step size adapted to them (H. Robbins, S. Monro 1951)."""
    part, sample = seeds, _joined(None, seeds, mode, threshold)
    logits = [np.log(step / (1.0 - step))]
    for count in range(1, CHAIN):
        part, acceptance = yield from _move(mode, level, part, 1.0 / (1.0 + np.exp(-logits[-1])), rng)
        # Chains that no move leaves are all tied; as seeds a few of them do.
        sample = _joined(sample, part, mode, threshold, 3 * len(seeds.states))
        logits.append(min(logits[-1] + 4.0 * (acceptance - ACCEPTANCE) / np.sqrt(count), 6.0))
    # The later half no longer depends on where the step began.
    mean = np.mean(logits[len(logits) // 2 :])
    return sample, float(1.0 / (1.0 + np.exp(-mean)))


def replica_evaluations(ladders: Sequence[Ladder]) -> int:
    """Return the rows that a replica takes unless it dies out."""
    return sum(ladder.chains * (CHAIN + (CHAIN - 1) * len(ladder.levels)) for ladder in ladders)


def replicate(
    number: int, dimension: int, ladders: Sequence[Ladder], curve: Array, rng: np.random.Generator
) -> Sampler[Replica]:
    """Return one unbiased estimate: all ladders, each climbed once.

    Args:
        number: number of the replica.
        dimension: dimension of the normals.
        ladders: one for each mode that can be reached.
        curve: increasing levels at which the largest demand is counted; the last is 1.
        rng: source of random numbers of the replica alone.
    """
    counted, probabilities, evaluations = np.zeros(len(curve)), list[float](), 0
    for ladder in ladders:
        uppers = (*ladder.levels, ladder.target)
        sample = yield from _draw(dimension, ladder.chains, ladder.mode, ladder.threshold(0), rng)
        evaluations += CHAIN * ladder.chains
        probability, lower = 1.0, -np.inf
        for place, upper in enumerate(uppers):
            is_last = place == len(ladder.levels)
            inside = (curve >= lower) & (curve <= upper if is_last else curve < upper)
            counted[inside] += probability * _shares(sample.values, ladder, ladders, curve[inside])
            probability *= float(np.mean(sample.values[:, ladder.mode] >= upper))
            if is_last or probability == 0.0:
                break
            sample = yield from _walk(ladder, place, _seeds(sample.survivors, ladder.chains, rng), rng)
            evaluations += (CHAIN - 1) * ladder.chains
            lower = upper
        probabilities.append(probability)
    return Replica(number, float(counted[-1]), tuple(probabilities), tuple(counted.tolist()), evaluations)


def _walk(ladder: Ladder, place: int, seeds: Population, rng: np.random.Generator) -> Sampler[Sample]:
    """Return chains from seeds above a level of the ladder."""
    level, threshold = ladder.levels[place], ladder.threshold(place + 1)
    part, sample = seeds, _joined(None, seeds, ladder.mode, threshold)
    for _ in range(CHAIN - 1):
        part, _share = yield from _move(ladder.mode, level, part, ladder.steps[place], rng)
        sample = _joined(sample, part, ladder.mode, threshold)
    return sample


def _shares(values: Array, ladder: Ladder, ladders: Sequence[Ladder], levels: Array) -> Array:
    """Return the probability of each level, divided among ladders that reach it."""
    columns = values[:, [other.mode for other in ladders]]
    targets = np.array([other.target for other in ladders])
    reaches = (columns[:, :, None] >= levels) & (targets[:, None] >= levels)
    mine = reaches[:, list(ladders).index(ladder)]
    return np.mean(mine / np.maximum(np.sum(reaches, axis=1), 1), axis=0)
