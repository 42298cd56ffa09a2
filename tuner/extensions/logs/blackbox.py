"""Blackbox files of Betaflight (.bbl, .bfl), decoded by the package betaflight-chirp-core.

A file holds a recording for each arming, each with a head of its own. Firmware that logs in high resolution counts rates in
tenths of a degree per second.
"""

from array import array
from itertools import pairwise
from operator import itemgetter
from typing import Any

import numpy as np

from plant.errors import InputError, require_package
from tuner.extensions.logs.betaflight import blackbox_log, columns_of
from tuner.extensions.logs.flight_log import STANDARD_GRAVITY, Array, FlightLog

MAGIC = b"H Product:Blackbox flight data recorder"
MAX_BLACKBOX_BYTES = 2**26
"""Largest file that is read [bytes]: a second of decoding for each MB."""
MAX_INTERVAL = 1024
"""Most loops between two frames that stand alone: 32 ms at 32 kHz."""
MAX_FIELDS = 256
"""Most fields of a frame."""
PAUSE = 1.0
"""Time between recordings whose clock restarts [s]."""


class _FrameColumns(list[Any]):
    """Frames as the decoder appends them, of which some columns are kept: all would take 50 times the file's size."""

    def __init__(self, places: list[int]) -> None:
        super().__init__()
        self._chosen = itemgetter(*places)
        self.values = array("d")

    def append(self, frame: Any, /) -> None:
        """Append the columns of a frame."""
        self.values.extend(self._chosen(frame))


class _DiscardedFrames(list[Any]):
    """Frames that are not read."""

    def append(self, frame: Any, /) -> None:
        """Append nothing."""


def is_blackbox(content: bytes) -> bool:
    """Return true for a file that begins as a recording."""
    return content[: len(MAGIC)] == MAGIC


def read_blackbox(content: bytes, name: str, digest: str) -> FlightLog:
    """Return the log; raises InputError where no recording can be read, MissingPackageError without the decoder."""
    require_package("betaflight_chirp_core", "logs", key=name)
    from betaflight_chirp_core import decoder

    if len(content) > MAX_BLACKBOX_BYTES:
        raise InputError(
            f"has {len(content) / 2**20:,.0f} MiB; of a blackbox file at most {MAX_BLACKBOX_BYTES / 2**20:.0f} MiB are read",
            file=name,
        )
    parts: list[Array] = []
    reason = "it holds no recording"
    for begin, end in decoder.split_sessions(content):
        try:
            parts.append(_recording(decoder.FlightLogParser(content, begin, end), name))
        except InputError as error:
            reason = error.message
        # The decoder meets whatever a damaged file holds, and raises as many kinds of errors.
        except Exception as error:
            reason = f"{type(error).__name__} in the last recording"
    parts = [part for part in parts if len(part)]
    if not parts:
        raise InputError(f"cannot be read as a blackbox file: {reason}", file=name)
    width = min(part.shape[1] for part in parts)
    table = np.concatenate([part[:, :width] for part in _one_after_the_other(parts)])
    notes = (f"{len(parts)} recordings, one after the other",) if len(parts) > 1 else ()
    return blackbox_log((name, "Betaflight blackbox (.bbl)", digest), table, notes)


def _recording(parser: Any, name: str) -> Array:
    """Return the columns (n, 11 or 14) of a recording in SI units, but for motors."""
    parser.parse_header()
    config, names = parser.sys_config, parser.main_field_names
    # The decoder counts the loops between frames one by one.
    if config["frameIntervalPNum"] < 1 or config["frameIntervalI"] > MAX_INTERVAL or len(names) > MAX_FIELDS:
        raise InputError("its head is damaged", file=name)
    columns = columns_of(names, name)
    frames = _FrameColumns([names.index(column) for column in columns])
    parser.main_frames = frames
    parser.slow_frames = parser.gps_frames = parser.events = _DiscardedFrames()
    parser.parse_data()
    table = np.array(frames.values).reshape(-1, len(columns))
    degree = np.pi / 180.0 / (10.0 if config.get("blackbox_high_resolution") == 1 else 1.0)
    unit = np.full(len(columns), degree)
    unit[0], unit[4:7], unit[7:11] = 1e-6, STANDARD_GRAVITY / float(config["acc_1G"]), 1.0
    return table * unit


def _one_after_the_other(parts: list[Array]) -> list[Array]:
    """Return recordings on one clock: a clock that restarts goes on a while after the recording before."""
    for before, after in pairwise(parts):
        after[:, 0] += max(0.0, before[-1, 0] + PAUSE - after[0, 0])
    return parts
