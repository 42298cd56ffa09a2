"""Margins of a loop of several rates, from its lifted form (`objectives.margins.lifting`).

A channel with one instant in the common period is a loop of one signal, whose margins are the classical ones at that period. A
faster channel has q instants and a matrix T(z) of q rows from the signals injected to the commands. Meaning of its margins:

    gain, phase         the least factor on all its commands, real or of modulus 1, with which the loop is not stable: with
                        t an eigenvalue of T(e^jwH), det(I + k L) = 0 where k = (1 + t)/t, so they are read from the
                        characteristic loci as from a curve (A. G. J. MacFarlane, I. Postlethwaite, Int. J. Control 25(1), 1977)
    delay               the least delay of its commands, det(I - (D - I) T) = 0 with the delay D between instants as a sampled
                        signal has it, each frequency w turned by e^-jwd; a whole number of steps is that of a queue
    peaks, disk         the largest singular value of T + c I over frequency, which is the l2 gain of the periodic loop, so the
                        disk holds for factors that change from instant to instant too (Bittanti and Colaneri, section 9.1)
    crossover           the highest frequency at which a locus crosses the unit circle
    bandwidth           from the part of y at the frequency of r itself

For loops that do not change from instant to instant all of them are the classical ones. A locus' frequency is that of the largest
part of its eigenvector among w + 2 pi k/H, which a lifted signal cannot tell apart.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from objectives.margins import classical, disk
from objectives.margins.block import EVERY, LINE, MULTILOOP, REAL, UNSTABLE, BlockReadings, modes_of_loops, read_block
from objectives.margins.classical import MarginAt
from objectives.margins.curve import NARROW, OFFSETS
from objectives.margins.frequency import Modes, frequency_grid
from objectives.margins.lifting import Rate, instants_of
from objectives.margins.linearise import LinearLoops
from objectives.margins.loci import CharacteristicLoci, TransferMatrix, delay_margin, find_crossings
from objectives.margins.multiloop import balanced
from objectives.margins.rejection import REJECTED
from objectives.margins.results import Realization
from objectives.margins.tracking import MAX_STEADY_SHARE, MIN_TRACKED_POWER

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Fields = frozenset[str]

# Halvings that find a bandwidth, and how often the interval about a peak is divided into how many points.
HALVINGS, ZOOMS, PARTS = 60, 10, 9
# Relative half-width of the difference that a group delay is.
DIFFERENCE = 1e-5
# Crossings and peaks of loci are refined, and a point of their grid takes as many eigenvalues as a channel has instants.
COARSER = 3
# Rival peaks that are looked at closer.
PEAKS = 3


@dataclass(frozen=True)
class Lifting:
    """The lifted form of the loops of a block.

    Attributes:
        control_period: Control period [s].
        periods: Number of control periods in the common period.
        instants: Instants of each channel, among those of the block.
        lowest: Lowest frequency that is looked at [rad/s].
        points: Points of a grid.
    """

    control_period: float
    periods: int
    instants: tuple[tuple[int, ...], ...]
    lowest: float
    points: int

    @property
    def period(self) -> float:
        """Common period [s]."""
        return self.control_period * self.periods

    @classmethod
    def of(cls, rates: Sequence[Rate], control_period: float, periods: int, lowest: float, points: int) -> "Lifting":
        """Return the form of channels with these rates."""
        return cls(control_period, periods, tuple(map(tuple, instants_of(rates, periods))), lowest, points)

    def step(self, channel: int) -> float:
        """Time between two instants of a channel [s]."""
        return self.period / len(self.instants[channel])


def read_lifted(
    loops: LinearLoops, form: Lifting, skew: float, plant_inputs: Sequence[int], requested: Fields
) -> BlockReadings:
    """Read the margins of lifted loops a (n, b, b) with closed terms.

    They are those of the channels of a form.
    skew: of the disks; plant_inputs: which channels are inputs of the plant.
    """
    modes = modes_of_loops(loops, EVERY)
    wanted = requested | {"disk"} if MULTILOOP in requested else requested
    single = wanted - {MULTILOOP}
    columns = [_channel(loops, modes, form, j, skew, single) for j in range(len(form.instants))]
    margins = {
        name: MarginAt(*[np.stack([column[name][i] for column in columns], axis=1) for i in (0, 1)])
        for name in sorted(single)
    }
    together = MarginAt(np.full(len(modes.size), np.inf), np.zeros(len(modes.size)))
    if MULTILOOP in requested and len(plant_inputs) == 1:
        together = MarginAt(*[part[:, plant_inputs[0]] for part in margins["disk"]])
    elif MULTILOOP in requested and plant_inputs:
        together = _together(loops, modes, form, plant_inputs, disk.center(skew))
    each = replace(modes, size=modes.size ** (1.0 / form.periods))
    return BlockReadings(each, {name: at for name, at in margins.items() if name in requested}, together)


def response(loops: LinearLoops, form: Lifting, row: int, frequency: Array) -> Complex:
    """Return T (f,) of the one channel of loops at frequencies (f,) [rad/s]; 0 for those that it cannot have.

    Of a channel with several instants it is the part of its command at the frequency of the signal injected.
    """
    instants = list(form.instants[0])
    if len(instants) == 1:
        return Realization(loops.a[row], loops.b[row, :, 0], loops.c[row, 0], form.period).response(frequency).t
    part = _part(loops, modes_of_loops(loops, EVERY), row, instants, instants)
    answer = _fundamental_of(part, form, 0)(frequency)
    return np.where(frequency <= np.pi / form.step(0) * (1.0 + 1e-12), answer, 0.0)


def _channel(
    loops: LinearLoops, modes: Modes, form: Lifting, j: int, skew: float, requested: Fields
) -> dict[str, MarginAt]:
    """Margins (n,) of one channel."""
    instants = form.instants[j]
    if len(instants) == 1:
        grid = frequency_grid(form.period, form.points, form.lowest)
        read = read_block(loops.of_channels(instants), grid, form.period, skew, [0], requested)
        return {name: MarginAt(at.value[:, 0], at.frequency[:, 0]) for name, at in read.quantities.items()}
    margins = {name: np.full((2, len(modes.size)), [[UNSTABLE[name]], [0.0]]) for name in requested}
    for row in np.flatnonzero(modes.stable):
        for name, at in _OfLoci(loops, modes, int(row), form, j, skew).read(requested).items():
            margins[name][:, row] = at
    return {name: MarginAt(*pair) for name, pair in margins.items()}


def _part(loops: LinearLoops, modes: Modes, row: int, outputs: list[int], inputs: list[int]) -> TransferMatrix:
    return TransferMatrix(
        modes.poles[row], modes.shown[row][outputs], modes.driven[row][:, inputs], loops.d[row][np.ix_(outputs, inputs)]
    )


class _OfLoci:
    """Margins of one channel of several instants of one stable loop: a value and a frequency of each."""

    def __init__(self, loops: LinearLoops, modes: Modes, row: int, form: Lifting, j: int, skew: float) -> None:
        instants, k = list(form.instants[j]), loops.n_channels
        self._form, self._j = form, j
        self._levels = {"sensitivity": 1.0, "complementary": 0.0, "disk": disk.center(skew)}
        self._part, self._tracked, self._loaded = (
            _part(loops, modes, row, [group * k + i for i in instants], [group * k + i for i in instants])
            for group in range(3)
        )
        self._w = _grid(form, modes.poles[row])

    def read(self, requested: Fields) -> dict[str, tuple[float, float]]:
        """Return those that are asked for."""
        margins = self._classical(requested) if requested & (REAL | LINE) else {}
        for name, level in self._levels.items():
            if name in requested:
                height, at = _highest(lambda w, level=level: _gain(self._part, w, self._form.period, level), self._w)
                margins[name] = (1.0 / height if name == "disk" else height, at)
        if "bandwidth" in requested:
            share = _fundamental_of(self._tracked, self._form, self._j)
            wide = _bandwidth(lambda w: np.abs(share(w)), self._form, self._j)
            margins["bandwidth"] = (wide, wide)
        if requested & {"rejection", "group_delay"}:
            margins |= self._of_fundamental(requested)
        if "load_index" in requested:
            margins["load_index"] = (_load_index(self._loaded, self._form.step(self._j)), 0.0)
        return margins

    def _of_fundamental(self, requested: Fields) -> dict[str, tuple[float, float]]:
        """Return rejection bandwidth and group delay by the fundamental of the command."""
        t = _fundamental_of(self._part, self._form, self._j)
        margins: dict[str, tuple[float, float]] = {}
        if "rejection" in requested:
            wide = _rejection(lambda w: np.abs(1.0 + t(w)), self._form, self._j)
            margins["rejection"] = (wide, wide)
        if "group_delay" in requested:
            at = self._classical(frozenset(["crossover"]))["crossover"][0]
            margins["group_delay"] = (_group_delay(t, at), at)
        return margins

    def _classical(self, requested: Fields) -> dict[str, tuple[float, float]]:
        loci = CharacteristicLoci(
            self._part, self._form.period, self._form.step(self._j), len(self._form.instants[self._j])
        )
        w, t = self._w, loci.values(self._w)
        real = [(abs(loci.frequency(at, value)[0]), value.real) for at, value in find_crossings(loci, w, t, level=None)]
        real += [(w[i], value.real) for i in (0, -1) for value in t[i] if abs(value.imag) < 1e-9 * abs(value)]
        line = find_crossings(loci, w, t, level=-0.5)
        crossed = [loci.frequency(at, value) for at, value in line]
        folded = [(abs(at), np.copysign(1.0, at) * value.imag) for at, value in crossed]
        margins = {
            name: (at.value.item(), at.frequency.item())
            for name, at in classical.read(_table(real), _table(folded)).items()
        }
        if "delay" in requested:
            margins["delay"] = delay_margin(loci, [at for at, _ in line], crossed)
        return {name: at for name, at in margins.items() if name in requested}


def _grid(form: Lifting, poles: Complex) -> Array:
    """Return the frequencies (f,) [rad/s] of a grid from 0 to pi/H.

    They are close at both ends, where those of fast loops are folded, and at resonances.
    """
    top, points = np.pi / form.period, form.points // COARSER
    near = np.geomspace(min(form.lowest, 1e-3 * top), 0.5 * top, points)
    middle, width = np.angle(poles) / form.period, -np.log(np.maximum(np.abs(poles), 1e-300)) / form.period
    narrow = (middle > 0.0) & (width < NARROW * middle)
    extra = (middle[narrow] + np.array(OFFSETS)[:, None] * width[narrow]).ravel()
    w = np.concatenate([[0.0, top], near, top - near[::2], np.linspace(0.0, top, points // 2), extra])
    return np.unique(w[(w >= 0.0) & (w <= top)])


def _table(pairs: list[tuple[float, float]]) -> Array:
    """Crossings (1, n, 2) as `classical` reads them, at least one row."""
    return np.array([pairs or [(np.nan, np.nan)]])


def _gain(part: TransferMatrix, w: Array, period: float, level: float) -> Array:
    """Largest singular value of T + c I at frequencies (f,)."""
    m = part.at(np.exp(1j * w * period))
    return np.linalg.norm(m + level * np.eye(m.shape[-1]), ord=2, axis=(-2, -1))


def _highest(height: Callable[[Array], Array], w: Array) -> tuple[float, float]:
    """Highest value of a function of frequencies (f,) and where it is."""
    values = height(w)
    last = len(w) - 1
    peaks = [i for i in np.argsort(values)[::-1] if values[i] >= max(values[max(i - 1, 0)], values[min(i + 1, last)])]
    return max(_peak(height, float(w[max(i - 1, 0)]), float(w[min(i + 1, last)])) for i in peaks[:PEAKS])


def _peak(height: Callable[[Array], Array], low: float, high: float) -> tuple[float, float]:
    best = (-np.inf, low)
    for _ in range(ZOOMS):
        w = np.linspace(low, high, PARTS)
        values = height(w)
        i = int(np.argmax(values))
        best = max(best, (float(values[i]), float(w[i])))
        low, high = w[max(i - 1, 0)], w[min(i + 1, PARTS - 1)]
    return best


def _fundamental_of(part: TransferMatrix, form: Lifting, channel: int) -> Callable[[Array], Complex]:
    """Return the function from frequencies (f,) to a sine's fundamental share.

    That is the share of the sine that comes back at its frequency.
    """

    def share(w: Array) -> Complex:
        wave = np.exp(1j * w[:, None] * form.step(channel) * np.arange(len(form.instants[channel])))
        answer = part.at(np.exp(1j * w * form.period)) @ wave[..., None]
        return np.mean(wave.conj() * answer[..., 0], axis=-1)

    return share


def _bandwidth(share: Callable[[Array], Array], form: Lifting, channel: int) -> float:
    """Highest frequency [rad/s] at which y follows r to within -3 dB."""
    w = np.geomspace(form.lowest, np.pi / form.step(channel), form.points // COARSER)
    above = share(w) ** 2 >= MIN_TRACKED_POWER
    if not above.any() or above[-1]:
        return float(w[-1]) if above.any() else 0.0
    i = int(np.flatnonzero(above)[-1])
    return _halved(lambda at: share(at) ** 2 >= MIN_TRACKED_POWER, w[i], w[i + 1])


def _rejection(sensitivity: Callable[[Array], Array], form: Lifting, channel: int) -> float:
    """Return the lowest frequency [rad/s] at which S exceeds -3 dB, if any."""
    w = np.geomspace(form.lowest, np.pi / form.step(channel), form.points // COARSER)
    above = sensitivity(w) ** 2 >= REJECTED
    if above[0] or not above.any():
        return 0.0
    i = int(np.flatnonzero(above)[0])
    return _halved(lambda at: sensitivity(at) ** 2 < REJECTED, w[i - 1], w[i])


def _halved(is_before: Callable[[Array], NDArray[np.bool_]], low: float, high: float) -> float:
    """Return the frequency [rad/s] between two at which a condition ends."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if is_before(np.array([middle]))[0] else (low, middle)
    return float(low)


def _group_delay(t: Callable[[Array], Complex], at: float) -> float:
    """Return the group delay [s] of L = -T/(1 + T) at a frequency [rad/s].

    It is a central difference, 0 where there is no crossover.
    """
    if at <= 0.0:
        return 0.0
    below, above = t(at * np.array([1.0 - DIFFERENCE, 1.0 + DIFFERENCE]))
    turned = np.angle((above / (1.0 + above)) / (below / (1.0 + below)))
    return float(-turned / (2.0 * DIFFERENCE * at))


def _load_index(part: TransferMatrix, step: float) -> float:
    """1/|integral of e dt| after a unit step of the load; 0 where a steady error stays."""
    shares = part.shown * part.driven.sum(axis=-1) / (1.0 - part.poles)
    steady = shares.sum(axis=-1) + part.direct.sum(axis=-1)
    if np.any(np.abs(steady) >= MAX_STEADY_SHARE * np.sum(np.abs(shares), axis=-1)):
        return 0.0
    integral = step * abs(np.sum(shares / (1.0 - part.poles)))
    return float(1.0 / integral) if integral > 0.0 else 0.0


def _together(loops: LinearLoops, modes: Modes, form: Lifting, inputs: Sequence[int], center: float) -> MarginAt:
    """Disk margin alpha (n,) in several inputs of the plant at once; one scale d for each input, as balances its blocks."""
    groups = [list(form.instants[j]) for j in inputs]
    members, owner = sum(groups, []), np.repeat(np.arange(len(groups)), [len(each) for each in groups])
    margins = []
    for row, stable in enumerate(modes.stable):
        part = _part(loops, modes, row, members, members)

        def bound(w: Array, part: TransferMatrix = part) -> Array:
            m = part.at(np.exp(1j * w * form.period)) + center * np.eye(len(members))
            sums = np.stack([(np.abs(m) ** 2)[:, owner == i].sum(axis=1) for i in range(len(groups))], axis=1)
            sizes = np.sqrt(np.stack([sums[..., owner == i].sum(axis=-1) for i in range(len(groups))], axis=-1))
            d = np.exp(balanced(sizes.astype(complex)))[:, owner]
            return np.linalg.norm(m * d[:, :, None] / d[:, None, :], ord=2, axis=(-2, -1))

        height, at = _highest(bound, _grid(form, modes.poles[row])) if stable else (np.inf, 0.0)
        margins.append((1.0 / height, at))
    return MarginAt(*np.array(margins).reshape(-1, 2).T)
