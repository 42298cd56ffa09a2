"""The Gaussian space of a flight: a vector of independent standard normals that represents all that is random in it.

A flight is drawn from generators of its parts (`plant.seeds.RandomSource`). Here they read a vector instead: normals as they
stand, uniform numbers by the normal distribution function (the transformation of Rosenblatt for independent numbers). A first
pass counts what each part reads, so the dimension is known and every number has its place. Vectors of independent normals
give flights of the same distribution as other generators, and the same vector gives the same flight.

A vehicle that cannot exist is drawn again (`plant.quadrotor.airframes.uncertainty`), from more numbers than were counted. Those
come from a generator whose seed is the digest of the part's vector: the flight remains a function of its vector.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from hashlib import blake2b
from math import prod
from typing import cast

import numpy as np

from plant.seeds import RandomSource

Array = np.ndarray
Shape = tuple[int, ...]
Read = Callable[[str, int, Shape], Array]
"""Gives numbers of a path in a shape, from the given place on."""


class NormalGenerator:
    """The members of NumPy's Generator that drawing a flight needs.

    Its numbers are `read` from a path, the name of a part and of the children that are spawned below it.
    """

    def __init__(self, read: Read, path: str) -> None:
        self._read, self._path, self._place = read, path, 0

    def standard_normal(self, size: int | tuple[int, ...] | None = None) -> Array | float:
        """Return the next normals."""
        shape = () if size is None else (size,) if isinstance(size, int) else size
        normals = self._read(self._path, self._place, shape)
        self._place += prod(shape)
        return float(normals) if size is None else normals

    def uniform(self, low: float = 0.0, high: float = 1.0, size: int | tuple[int, ...] | None = None) -> Array | float:
        """Return the next numbers, uniform from low to high."""
        return low + (high - low) * _distribution()(self.standard_normal(size))

    def spawn(self, count: int) -> list["NormalGenerator"]:
        """Return the generators of children, each with numbers of its own."""
        return [NormalGenerator(self._read, f"{self._path}/{k}") for k in range(count)]


@dataclass(frozen=True)
class NormalSpace:
    """Places of the normals of a flight in its vector.

    Attributes:
        dimension: Number of normals.
        parts: Slice of each part that is drawn, such as "air", in the order of the vector.
        paths: Slice of each path within the parts: of the part itself, and of every child that it spawns.
        arrays: Place and shape of each array that is read, rows of processes in time first.

    """

    dimension: int
    parts: dict[str, slice]
    paths: dict[str, slice]
    arrays: tuple[tuple[int, Shape], ...]

    @classmethod
    def of(cls, draw: Callable[[RandomSource], object]) -> "NormalSpace":
        """Return the space of a draw of one flight.

        It is counted in a pass in which all normals are 0.
        """
        reads = dict[str, dict[str, dict[int, Shape]]]()

        def source(part: str, _: int) -> np.random.Generator:
            paths = reads.setdefault(part, {})

            def read(path: str, place: int, shape: Shape) -> Array:
                paths.setdefault(path, {})[place] = shape
                return np.zeros(shape)

            return cast("np.random.Generator", NormalGenerator(read, part))

        draw(source)
        parts, slices, arrays, end = dict[str, slice](), dict[str, slice](), list[tuple[int, Shape]](), 0
        for part, paths in reads.items():
            begin = end
            for path, shapes in sorted(paths.items()):
                arrays += [(end + place, shape) for place, shape in shapes.items()]
                count = max(place + prod(shape) for place, shape in shapes.items())
                slices[path] = slice(end, end + count)
                end += count
            parts[part] = slice(begin, end)
        drawn = {part: place for part, place in parts.items() if place.stop > place.start}
        return cls(end, drawn, slices, tuple(arrays))

    def source(self, vectors: Sequence[Array] | Array) -> RandomSource:
        """Return the source whose flight i reads vector i (dimension,)."""

        def of_flight(part: str, index: int) -> np.random.Generator:
            def read(path: str, place: int, shape: Shape) -> Array:
                return self._read(vectors[index], path, place, prod(shape)).reshape(shape)

            return cast("np.random.Generator", NormalGenerator(read, part))

        return of_flight

    def _read(self, vector: Array, path: str, place: int, count: int) -> Array:
        counted = vector[self.paths[path]]
        if place + count <= len(counted):
            return counted[place : place + count]
        more = _further(counted, place + count - len(counted))
        return np.concatenate([counted, more])[place:]


@cache
def _distribution() -> Callable[[Array | float], Array]:
    """Return the normal distribution function; SciPy takes 0.2 s to import."""
    from scipy.special import ndtr  # pyright: ignore[reportMissingTypeStubs]

    return ndtr


def _further(counted: Array, count: int) -> Array:
    """Return normals behind those of a path, a function of them."""
    seed = int.from_bytes(blake2b(np.ascontiguousarray(counted).tobytes(), digest_size=16).digest(), "little")
    return np.random.Generator(np.random.PCG64DXSM(seed)).standard_normal(count)
