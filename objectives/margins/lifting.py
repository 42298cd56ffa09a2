"""Loops of several rates as one of a single rate: the signals of all instants of their common period stand side by side.

Channels that step every few control periods make the loop periodic: x(k+1) = A_k x(k) + B_k u(k), with the A_k and B_k of one
common period over and over. Lifted, that is a loop of constant matrices from one common period to the next, whose state matrix is
the monodromy matrix A_{N-1} ... A_0 (S. Bittanti, P. Colaneri, Periodic Systems: Filtering and Control, Springer 2009, sections
3.1 and 6.2). Its poles decide stability exactly.

A signal of a channel is given at the channel's instants and held in between, so a channel that steps once in a common period has
one signal, and a faster one as many as it has instants.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import gcd, lcm
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from objectives.margins.frequency import moved, without_idle
from objectives.margins.linearise import LinearLoops
from objectives.margins.structure import Block, with_terms
from plant.errors import InputError
from plant.model.plan import Channel, LoopPlan

Array = NDArray[np.float64]

# Longest common period [control periods]: the matrices of a fast channel have as many rows.
MAX_PERIODS = 64


class Rate(NamedTuple):
    """Rate of a channel, in control periods.

    every, first: from one instant at which its command may change where its loop is broken to the next, and number of the first.
    step: from one step of its law to the next.
    """

    every: int
    first: int
    step: int


def common_period(channels: Iterable[int], rates: Sequence[Rate]) -> int:
    """Return the control periods after which some channels step at once again."""
    return lcm(*[rates[channel].step for channel in channels])


def rates_of(plan: LoopPlan, control_period: float) -> tuple[Rate, ...]:
    """Return the rate of every channel at its break point.

    control_period: h [s].
    The set point of another channel changes as its channel steps, an input as any of its channels does, as many periods later as
    it is delayed. Raises InputError where it takes too many periods until all channels step at once again.
    """
    periods = lcm(*[channel.every for channel in plan.channels])
    if periods > MAX_PERIODS:
        rates = ", ".join(str(channel.every) for channel in plan.channels)
        raise InputError(
            f"channels that step every {rates} periods step together every {periods} periods; margins are known up to "
            f"{MAX_PERIODS}: choose rates that divide each other, or leave the margins out",
            key="margin",
        )
    return tuple(_rate(channel, plan, control_period) for channel in plan.channels)


def _rate(channel: Channel, plan: LoopPlan, control_period: float) -> Rate:
    if plan.cascades(channel):
        return Rate(channel.every, 0, channel.every)
    every = gcd(*[each.every for each in plan.acting_on(channel.to)])
    late = next(actuator for actuator in plan.actuators if actuator.name == channel.to).periods(control_period)
    return Rate(every, late % every, channel.every)


def over_period(
    block: Block, phases: Sequence[LinearLoops], term: Array, picked: tuple[int, ...], rates: Sequence[Rate]
) -> LinearLoops:
    """Return loops of a block over its common period.

    Args:
        block: The block.
        phases: All its loops (n, ...) in each control period of the common one, terms left open.
        term: Gains (n, cases, terms) of all terms; rows of the result are candidates, then cases.
        picked: Channels of the result, the loops of the others stay closed.
        rates: Rates of the channels of the result.
    """
    places = [block.channels.index(channel) for channel in picked]
    closed = {id(phase): with_terms(block, phase, term) for phase in phases}
    if picked != block.channels:
        closed = {key: loops.of_channels(places) for key, loops in closed.items()}
    if len(phases) == 1:
        return closed[id(phases[0])]
    loops = lifted([closed[id(phase)] for phase in phases], rates)
    # Values that are held and given anew are chains of poles at 0, whose eigenvectors depend on each other.
    return replace(loops, a=moved(without_idle(loops.a, loops.b[..., loops.injected])))


def lifted(phases: Sequence[LinearLoops], rates: Sequence[Rate]) -> LinearLoops:
    """Return the loops over one common period, terms closed.

    phases: loops of every control period in it.
    Its channels are the instants of the first channel in order, then those of the second and so on. Its last states are the
    values that signals v, r and load of the channels are held at.
    """
    moving = _Moving(phases[0], rates, len(phases))
    for k, loops in enumerate(phases):
        moving.step(k, loops)
    return moving.loops()


def instants_of(rates: Sequence[Rate], periods: int) -> list[range]:
    """Return the channels of the lifted loops that are each channel's instants."""
    ends = np.cumsum([0, *[periods // rate.every for rate in rates]]).tolist()
    return [range(low, high) for low, high in zip(ends[:-1], ends[1:], strict=True)]


class _Moving:
    """State, held signals and readings so far in a common period.

    They are rows by the state at its start and all signals in it.
    """

    def __init__(self, first: LinearLoops, rates: Sequence[Rate], periods: int) -> None:
        n, x, k = len(first.a), first.a.shape[-1], first.n_channels
        self._x, self._k, self._instants = x, k, instants_of(rates, periods)
        self._count = self._instants[-1].stop
        # v, r and load of every channel; v comes at the break point's instants, the others at those of the law.
        late = [rate.first for rate in rates]
        self._first, self._every = [*late, *[0] * 2 * k], [rate.every for rate in rates] * 3
        self._rows = np.zeros((n, x + 3 * k, x + 3 * k + 3 * self._count))
        self._rows[:] = np.eye(*self._rows.shape[1:])
        self._read = np.zeros((n, 3 * self._count, self._rows.shape[-1]))

    def step(self, k: int, loops: LinearLoops) -> None:
        """Go on by control period k."""
        x = self._x
        for signal in range(3 * self._k):
            instant = self._instant(signal, k)
            if instant is not None:
                self._rows[:, x + signal] = 0.0
                self._rows[:, x + signal, x + 3 * self._k + instant] = 1.0
        inputs = _without_terms(loops, loops.injected, loops.reference, loops.load)
        outputs = _without_terms(loops, loops.command, loops.output, loops.error)
        seen = loops.c[:, outputs] @ self._rows[:, :x] + loops.d[:, outputs][:, :, inputs] @ self._rows[:, x:]
        for signal in range(3 * self._k):
            instant = self._instant(signal, k)
            if instant is not None:
                self._read[:, instant] = seen[:, signal]
        self._rows[:, :x] = loops.a @ self._rows[:, :x] + loops.b[:, :, inputs] @ self._rows[:, x:]

    def loops(self) -> LinearLoops:
        """Return the loops over the common period."""
        size = self._rows.shape[1]
        parts = [part[:, :, span] for part in (self._rows, self._read) for span in (slice(size), slice(size, None))]
        return LinearLoops(*parts, n_channels=self._count, n_terms=0)

    def _instant(self, signal: int, k: int) -> int | None:
        """Return the column of a signal at period k, or None.

        Signals are v, r and load of all channels in turn; None where k is not one of the signal's instants.
        """
        number, rest = divmod(k - self._first[signal], self._every[signal])
        group, channel = divmod(signal, self._k)
        return None if rest else group * self._count + self._instants[channel][number]


def _without_terms(loops: LinearLoops, *spans: slice) -> NDArray[np.intp]:
    return np.concatenate([np.arange(loops.c.shape[-2])[span] for span in spans])
