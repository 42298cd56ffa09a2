"""Threads of this process: how many there may be, and independent tasks in parallel.

A task gains by it where it spends its time in compiled code that gives the interpreter's lock away. The results do not depend on
the number of threads: each task is worked out by itself, and they are returned in the order of the items.
"""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


def available_threads() -> int:
    """Return the number of cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def parallel_map(task: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """Return the result of a task for each item, in their order; a task must not call this itself."""
    several = list(items)
    if len(several) < 2 or threads_used() < 2:
        return [task(one) for one in several]
    return list(_pool(threads_used()).map(task, several))


def shares(count: int, least: int) -> list[slice]:
    """Return a range of rows for each thread, of at least `least` rows."""
    parts = max(min(threads_used(), count // least), 1)
    bounds = [count * part // parts for part in range(parts + 1)]
    return [slice(first, last) for first, last in zip(bounds, bounds[1:], strict=False)]


def use_threads(most: int | None) -> None:
    """Work on so many threads from now on; None: one for each core."""
    _MAX_THREADS[0] = most


def threads_used() -> int:
    """Return the number of threads that tasks share."""
    return _MAX_THREADS[0] or available_threads()


_MAX_THREADS: list[int | None] = [None]


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads)


if hasattr(os, "register_at_fork"):
    # A child has none of its parent's threads.
    os.register_at_fork(after_in_child=_pool.cache_clear)
