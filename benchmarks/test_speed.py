# ruff: noqa: D102, D103, D105, D107
"""Speeds to watch from release to release, by pytest-benchmark: `python -m pytest benchmarks --benchmark-only -n 0`.

Not part of the test suite (`testpaths` is tests/), for a timing is no fact about the code. `--benchmark-autosave` and
`--benchmark-compare` show what a change did on one machine.
"""

from pathlib import Path
from typing import Any

import pytest

from benchmarks.course import Course, draw
from benchmarks.peers import ceiling, lanes, vectorised

pytest.importorskip("pytest_benchmark")

BATCH, PERIODS = 256, 250


@pytest.fixture(scope="session")
def course() -> Course:
    return draw(duration=2.0)


@pytest.mark.parametrize("threads", [1, 0], ids=["one thread", "all threads"])
def test_lanes(benchmark: Any, course: Course, tmp_path: Path, threads: int) -> None:
    benchmark(lanes.prepare(course, BATCH, PERIODS, threads, tmp_path))


def test_one_flight(benchmark: Any, course: Course, tmp_path: Path) -> None:
    benchmark(lanes.prepare(course, 1, PERIODS, 1, tmp_path))


def test_numpy(benchmark: Any, course: Course, tmp_path: Path) -> None:
    benchmark.pedantic(vectorised.prepare(course, 64, 25, 1, tmp_path), rounds=5, warmup_rounds=1)


@pytest.mark.skipif(ceiling.compiler() is None, reason="no C compiler")
def test_c(benchmark: Any, course: Course, tmp_path: Path) -> None:
    benchmark(ceiling.prepare(course, BATCH, PERIODS, 1, tmp_path))


def test_drawing_scenarios(benchmark: Any) -> None:
    benchmark.pedantic(lambda: draw(16, 4.0), rounds=5, warmup_rounds=1)


def test_counting_is_exact_for_a_known_expression() -> None:
    """Twelve operations, counted by hand: norm of three components (3 products, 2 sums, 1 root) and a cross product (6, 3)."""
    from collections import Counter

    from benchmarks.counting import lifted, names, operations
    from plant.backends.rebind import Rebinder
    from plant.vectors import Vec3, cross, norm3

    counts: Counter[str] = Counter()
    bind, vector = Rebinder(names(counts)), lifted(Vec3(1.0, 2.0, 2.0), counts)
    assert bind(norm3)(vector).value == 3.0
    assert dict(counts) == {"multiply": 3, "add": 2, "sqrt": 1} and operations(counts) == 6
    counts.clear()
    bind(cross)(vector, vector)
    assert dict(counts) == {"multiply": 6, "add": 3}
