"""Blocks of the linearized loop, identified from its numbers.

States, channels and terms of a block belong together.
Written in sums and differences of rotors and in the attitude relative to the trim, the loop at hover falls into blocks: x with
pitch, y with roll, z, yaw. Gains act within one channel, so what couples channels does not depend on them and the structure is
read off once, from a few probes. States that no injected signal reaches or that no command depends on belong to no loop and are
left out: the place in attitude mode, the count of yaw turns.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from objectives.margins.balancing import balancing_scale
from objectives.margins.closing import close_terms
from objectives.margins.linearise import LinearLoops
from objectives.margins.period import BODY, CHANNELS, PeriodMap
from plant.quadrotor.nominal import mixer_matrix
from plant.quadrotor.rigid_body import Body
from plant.quadrotor.vehicle import Vehicle
from plant.records import paths, rows

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Couplings below this, between states scaled alike, do not count. What returns by way of another block has passed two of them, so
# leaving them out changes no loop by more than the square of this.
COUPLED = 1e-8
# Relative difference up to which two blocks are alike, and points of the plane where they are compared.
ALIKE, TRIED = 1e-8, (1.1 + 0.3j, 0.95 + 0.3j, -0.5 + 0.9j)
# What a quarter turn of yaw makes of each channel.
TURNED = {"x": "y", "y": "x", "z": "z", "roll": "pitch", "pitch": "roll", "yaw": "yaw"}


@dataclass(frozen=True)
class Block:
    """A part of the loop that nothing else acts on.

    Attributes:
        channels: Indices in CHANNELS.
        terms: Indices of its nonlinear terms.
        into: Matrix (b, x) from all states to those of the block.
        out_of: Matrix (x, b) back.
        image: Index of an earlier block that this one is, turned by 90 deg of yaw, wherever their gains are alike.
    """

    channels: tuple[int, ...]
    terms: tuple[int, ...]
    into: Array
    out_of: Array
    image: int | None = None

    @property
    def label(self) -> str:
        """Names of its channels."""
        return " and ".join(CHANNELS[i] for i in self.channels)

    def part(self, loops: LinearLoops) -> LinearLoops:
        """Return the block's own loops."""
        k, first = loops.n_channels, np.array(self.channels, dtype=int)
        w = k + np.array(self.terms, dtype=int)
        after = k + loops.n_terms
        u = np.concatenate([first, w, after + first, after + k + first])
        o = np.concatenate([first, w, after + first, after + k + first])
        # Most columns of `into` are zero: rotors and attitude come in fours, all else stands alone.
        near = np.nonzero(np.any(self.into != 0.0, axis=0))[0]
        into, out_of = self.into[:, near], self.out_of[near]
        return LinearLoops(
            into @ loops.a[:, near][:, :, near] @ out_of,
            into @ loops.b[:, near][:, :, u],
            loops.c[:, o][:, :, near] @ out_of,
            loops.d[:, o][:, :, u],
            len(self.channels),
            len(self.terms),
        )


def with_terms(block: Block, part: LinearLoops, term: Array) -> LinearLoops:
    """A block's own loops, closed with term gains (n, cases, terms): rows are candidates, then cases, where it has terms."""
    return close_terms(part.expanded(), term[:, :, list(block.terms)]).flattened() if block.terms else part


def coordinates(period: PeriodMap, vehicle: Vehicle, body: Array) -> Array:
    """Return the change of coordinates (x, x) for blocks.

    It is to sums and differences of rotors and to the attitude relative to that of a body (17,).
    """
    names = paths(period.state)
    change = np.eye(len(names))
    mixer = mixer_matrix(vehicle)
    mixer /= np.linalg.norm(mixer, axis=1, keepdims=True)
    for i, name in enumerate(names):
        if name.endswith(".r1"):
            change[i : i + 4, i : i + 4] = mixer
    turn = rows(Body, "attitude")
    w, x, y, z = body[:BODY][turn]
    change[turn, turn] = [[w, x, y, z], [-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]]
    return change


def blocks_of(closed: LinearLoops, change: Array) -> tuple[Block, ...]:
    """Return the blocks of probes (n, ...) with closed terms.

    change (x, x): matrix of the coordinates.
    """
    back: Array = np.linalg.inv(change).astype(float)
    size = np.max(np.abs(change @ closed.a @ back), axis=0)
    scale = balancing_scale(size)
    into, out_of = np.asarray(change / scale[:, None]), np.asarray(back * scale)
    moves = size / scale[:, None] * scale > COUPLED
    driven, seen = _coupled(into @ closed.b), _coupled(closed.c @ out_of)
    reaching = _paths_of(moves)
    after = reaching @ driven
    looped = np.any(seen[closed.command] & after[:, closed.injected].T, axis=1)
    members_of_loops = np.any(after[:, closed.injected][:, looped], axis=1) & np.any(
        (seen[closed.command] @ reaching)[looped], axis=0
    )
    # Undirected graph of kept states, looped channels and terms.
    links = np.concatenate([seen[: closed.terms.stop], driven[:, : closed.terms.stop].T], axis=0)
    count, label = _components(moves & members_of_loops & members_of_loops[:, None], links & members_of_loops)
    x, k, w = len(members_of_loops), closed.n_channels, closed.n_terms
    parts = []
    for i in range(count):
        states = members_of_loops & (label[:x] == i)
        members = label[x : x + k + w] == i
        channels = np.nonzero(members[:k] & looped)[0]
        if states.any() and len(channels):
            acting = np.any(driven[states], axis=0)[closed.terms] & np.any(seen[:, states], axis=1)[closed.terms]
            terms = np.nonzero(members[k:] & acting)[0]
            parts.append(Block(tuple(channels.tolist()), tuple(terms.tolist()), into[states], out_of[:, states]))
    return tuple(sorted(parts, key=lambda block: block.channels))


def with_images(blocks: tuple[Block, ...], loops: Callable[[Block, slice], LinearLoops]) -> tuple[Block, ...]:
    """Find which blocks are images.

    loops: of a block, closed, under some of the probes, whose gains are alike in x and y, roll and pitch. The first probe alone
    tells most blocks apart; loops of a slow vehicle at 4 kHz take 0.1 s a probe.
    """

    def is_image(one: Block, other: Block) -> bool:
        return all(same_loops(loops(one, rows), loops(other, rows)) for rows in (slice(1), slice(None)))

    out: list[Block] = []
    for i, block in enumerate(blocks):
        turned = tuple(CHANNELS.index(TURNED[CHANNELS[c]]) for c in block.channels)
        earlier = [j for j in range(i) if blocks[j].channels == turned and is_image(blocks[j], block)]
        out.append(replace(block, image=earlier[0] if earlier else None))
    return tuple(out)


def same_loops(first: LinearLoops, second: LinearLoops) -> bool:
    """Return True if two blocks' closed loops have equal poles and responses.

    first, second: batches of loops. The responses are those in each channel.
    """
    if first.a.shape != second.a.shape or first.n_channels != second.n_channels:
        return False
    poles = [np.sort_complex(np.poly(a)) for loops in (first, second) for a in loops.a]
    half = len(poles) // 2
    if not np.allclose(poles[:half], poles[half:], rtol=0.0, atol=ALIKE * np.abs(poles).max()):
        return False
    return all(_same_response(first, second, z) for z in TRIED)


def _same_response(first: LinearLoops, second: LinearLoops, z: complex) -> bool:
    one, two = (_diagonal_responses(loops, z) for loops in (first, second))
    return np.allclose(one, two, rtol=ALIKE, atol=0.0)


def _diagonal_responses(loops: LinearLoops, z: complex) -> NDArray[np.complex128]:
    """Return each channel's responses at z.

    They are those of the command to v, the output to r and the error to the load.
    """
    state = np.linalg.solve(z * np.eye(loops.a.shape[-1]) - loops.a, loops.b)
    responses = loops.c @ state + loops.d
    pairs = ((loops.command, loops.injected), (loops.output, loops.reference), (loops.error, loops.load))
    return np.stack([np.diagonal(responses[..., o, u], axis1=-2, axis2=-1) for o, u in pairs])


def _coupled(probes: Array) -> Mask:
    return np.max(np.abs(probes), axis=0) > COUPLED


def _paths_of(moves: Mask) -> Mask:
    """Return the reachability of states (rows) from states (columns) in any number of periods."""
    paths_so_far = moves | np.eye(len(moves), dtype=bool)
    for _ in range(int(np.ceil(np.log2(len(moves))))):
        # Counted in numbers: products of Boolean matrices take 20 times as long.
        counts = paths_so_far.astype(np.float32)
        longer = counts @ counts > 0.0
        if np.array_equal(longer, paths_so_far):
            break
        paths_so_far = longer
    return paths_so_far


def _components(moves: Mask, links: Mask) -> tuple[int, NDArray[np.intp]]:
    """Connected components of states, and of the signals linked to them: outputs and inputs, each once."""
    x, half = len(moves), len(links) // 2
    graph = np.zeros((x + half, x + half), dtype=bool)
    graph[:x, :x] = moves
    graph[x:, :x] = links[:half] | links[half:]
    # Each is told by the first of its members. (SciPy finds them too, but its graphs take 0.03 s to import.)
    first, label = np.unique(np.argmax(_paths_of(graph | graph.T), axis=0), return_inverse=True)
    return len(first), label
