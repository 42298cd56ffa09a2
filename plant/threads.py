"""Threads of this process: how many there may be, and independent tasks side by side on them.

A task gains by it where it spends its time in compiled code that gives the interpreter's lock away. The results do not depend on
the number of threads: each task is worked out by itself, and they are returned in the order of what they were asked for.
"""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

Asked = TypeVar("Asked")
Found = TypeVar("Found")


def available_threads() -> int:
    """Return the number of cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def side_by_side(task: Callable[[Asked], Found], asked: Iterable[Asked]) -> list[Found]:
    """Return what a task finds for each of what it is asked; a task must not call this itself."""
    several = list(asked)
    if len(several) < 2 or threads_used() < 2:
        return [task(one) for one in several]
    return list(_pool(threads_used()).map(task, several))


def shares(count: int, least: int) -> list[slice]:
    """Return a range of rows for each thread, fewer where one would have less than the `least` that is worth it."""
    parts = max(min(threads_used(), count // least), 1)
    bounds = [count * part // parts for part in range(parts + 1)]
    return [slice(first, last) for first, last in zip(bounds, bounds[1:], strict=False)]


def use_threads(most: int | None) -> None:
    """Work on so many threads from now on; None: one for each core."""
    _MOST[0] = most


def threads_used() -> int:
    """Return the number of threads that tasks share."""
    return _MOST[0] or available_threads()


_MOST: list[int | None] = [None]


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads)


if hasattr(os, "register_at_fork"):
    # A child has none of its parent's threads.
    os.register_at_fork(after_in_child=_pool.cache_clear)
