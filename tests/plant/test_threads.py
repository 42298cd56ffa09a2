"""Tasks side by side: order, shares, and bits that do not depend on the number of threads."""

from collections.abc import Iterator
from time import sleep

import numpy as np
import pytest

from objectives.margins.frequency import modes_of
from plant.threads import available_threads, parallel_map, shares, threads_used, use_threads
from tuner.search.bayesian_optimization import BayesianOptimization


@pytest.fixture(autouse=True)
def as_before() -> Iterator[None]:
    yield
    use_threads(None)


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_answers_come_in_the_order_of_the_questions(threads: int) -> None:
    use_threads(threads)

    def late(number: int) -> int:
        sleep(0.002 * (4 - number))
        return number**2

    assert parallel_map(late, range(5)) == [0, 1, 4, 9, 16]


def test_an_error_reaches_who_asked() -> None:
    use_threads(2)
    with pytest.raises(ZeroDivisionError):
        parallel_map(lambda number: 1 // number, [1, 0, 2])


@pytest.mark.parametrize("threads", [1, 3, 8])
@pytest.mark.parametrize("count", [0, 1, 15, 16, 33, 500])
def test_shares_take_every_row_once(threads: int, count: int) -> None:
    use_threads(threads)
    found = shares(count, 16)
    assert np.concatenate([np.arange(count)[rows] for rows in found]).tolist() == list(range(count))
    assert len(found) <= threads
    assert len(found) == 1 or min(rows.stop - rows.start for rows in found) >= 16


def test_as_many_threads_as_cores_unless_told() -> None:
    assert threads_used() == available_threads()
    use_threads(3)
    assert threads_used() == 3


def test_margins_have_the_same_bits_on_any_number_of_threads() -> None:
    draw = np.random.default_rng(1)
    a, b, c = draw.normal(size=(70, 9, 9)), draw.normal(size=(70, 9, 2)), draw.normal(size=(70, 2, 9))
    found = []
    for threads in (1, 4):
        use_threads(threads)
        modes = modes_of(a, b, c)
        found.append([part.tobytes() for part in (modes.poles, modes.shown, modes.driven, modes.size)])
    assert found[0] == found[1]


def test_a_search_asks_for_the_same_points_on_any_number_of_threads() -> None:
    first, asked = np.random.default_rng(2).uniform(size=(8, 3)), []
    for threads in (1, 4):
        use_threads(threads)
        excess = lambda points: np.stack([points[:, 0] - 0.7, 0.2 - points[:, 1]], 1)  # noqa: E731
        search = BayesianOptimization(first, 2, 1, 3, [excess])
        points = first
        for _ in range(4):
            points = search.ask()
            values = np.stack([np.square(points - 0.3).sum(axis=1), np.square(points - 0.8).sum(axis=1)], axis=1)
            search.tell(values, np.maximum(points[:, 2:] - 0.9, 0.0))
        asked.append(points.tobytes())
    assert asked[0] == asked[1]
