"""Circles of garbage: a short command does not look for them, not even as it ends, and nothing is lost to those who do later."""

import gc
import weakref

import pytest

from tuner.text.errors import NEW_OBJECTS, seldom_collected


class Circle:
    """An object that only the garbage collector takes away."""

    def __init__(self):
        self.own = self


@pytest.fixture(autouse=True)
def _nothing_is_frozen():
    gc.unfreeze()
    yield
    gc.unfreeze()


def test_a_short_command_looks_for_no_garbage_and_leaves_it_to_who_looks_later():
    looked, usual = [], gc.get_threshold()

    def note(phase, info):
        looked.append((phase, info))

    gc.collect()
    gc.callbacks.append(note)
    try:
        with seldom_collected():
            circle = weakref.ref(Circle())
            kept = [[] for _ in range(NEW_OBJECTS // 2)]
        kept.append([])
        assert looked == []
    finally:
        gc.callbacks.remove(note)
    assert gc.get_threshold() == usual
    assert circle() is not None
    gc.collect()
    assert circle() is None


def test_a_long_command_looks_for_garbage():
    gc.collect()
    with seldom_collected():
        circle = weakref.ref(Circle())
        kept = [[] for _ in range(NEW_OBJECTS + 1000)]
        assert circle() is None
    assert kept


def test_objects_that_the_caller_froze_stay_frozen():
    gc.freeze()
    n_frozen = gc.get_freeze_count()
    with seldom_collected():
        pass
    # A frozen object that nothing refers to any more is gone all the same.
    assert n_frozen - 1000 < gc.get_freeze_count() <= n_frozen
