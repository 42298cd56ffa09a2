"""Circles of garbage: a short command does not look for them, not even as it ends, and nothing is lost to those who do later."""

import gc
import subprocess
import sys
import weakref

from tuner.text.errors import NEW_OBJECTS, seldom_collected

# A process of its own: this one has millions of frozen objects of other tests, which stay frozen.
SHORT = """
import gc
import weakref
from contextlib import suppress

from tuner.text.errors import NEW_OBJECTS, leave, seldom_collected


class Circle:
    def __init__(self):
        self.own = self


looked, usual = [], gc.get_threshold()
gc.collect()
gc.callbacks.append(lambda *seen: looked.append(seen))
with suppress(SystemExit), seldom_collected():
    circle = weakref.ref(Circle())
    kept = [[] for _ in range(NEW_OBJECTS // 2)]
    leave(0)
kept.append([])
gc.callbacks.clear()
assert looked == []
assert gc.get_threshold() == usual
assert circle() is not None
gc.unfreeze()
gc.collect()
assert circle() is None
"""


class Circle:
    """An object that only the garbage collector takes away."""

    def __init__(self):
        self.own = self


def test_a_short_command_looks_for_no_garbage_and_leaves_it_to_who_looks_later():
    done = subprocess.run([sys.executable, "-c", SHORT], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr


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
