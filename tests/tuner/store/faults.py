"""A disk that fails, and a person who presses Ctrl-C, at the n-th write, fsync or rename below a folder."""

import errno
import io
import os
import signal
from pathlib import Path

FULL, BEFORE, AFTER = "full", "ctrl-c before", "ctrl-c after"
KINDS = (FULL, BEFORE, AFTER)


class Faults:
    """Counts the writes, fsyncs and renames below a folder while it is entered; the n-th of them goes wrong.

    What fails is the call into the system itself: `os.replace`, `os.fsync`, and the write of an open file, of which half
    has reached the disk when it is full. count: of the calls so far. told: the call that went wrong.
    """

    def __init__(self, folder, nth=None, kind=FULL):
        self._folder, self._nth, self._kind = str(folder), nth, kind
        self.count, self.told = 0, None

    def __enter__(self):
        self._before = os.replace, os.fsync, io.open
        replace, fsync, opened = self._before

        def watched_open(file, mode="r", *rest, **named):
            stream = opened(file, mode, *rest, **named)
            if set(mode) & set("wax") and str(file).startswith(self._folder):
                return Watched(stream, self, file)
            return stream

        os.replace = lambda source, target: self.call("rename", target, lambda: replace(source, target))
        os.fsync = lambda handle: self.call("fsync", place_of(handle), lambda: fsync(handle))
        io.open = watched_open
        return self

    def __exit__(self, *_):
        os.replace, os.fsync, io.open = self._before

    def call(self, what, place, do, half=lambda: None):
        if not str(place).startswith(self._folder):
            return do()
        self.count += 1
        if self.count != self._nth:
            return do()
        self.told = f"{what} {Path(place).name}"
        if self._kind == FULL:
            half()
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(place))
        if self._kind == BEFORE:
            signal.raise_signal(signal.SIGINT)
        done = do()
        signal.raise_signal(signal.SIGINT)
        return done


class Watched:
    """An open file whose writes are counted."""

    def __init__(self, stream, faults, place):
        self._stream, self._faults, self._place = stream, faults, place

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._stream.close()

    def __getattr__(self, name):
        return getattr(self._stream, name)

    def write(self, content):
        def half():
            self._stream.write(content[: len(content) // 2])

        return self._faults.call("write", self._place, lambda: self._stream.write(content), half)


def place_of(handle):
    return os.readlink(f"/proc/self/fd/{handle}")
