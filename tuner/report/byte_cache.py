"""Cache of bytes that are the same in every report and take long to make, next to the compiled kernels."""

import os
from collections.abc import Callable
from contextlib import suppress

from plant.backends.cache import cache_folder
from plant.backends.sealed import DIGEST, SEAL, private_folder, sealed
from plant.output_files import write_new_file


def cached(name: str, make: Callable[[], bytes]) -> bytes:
    """Return the bytes of a name, which says all that decides them.

    They are made where the cache has none, or damaged ones.
    """
    folder = private_folder(cache_folder() / "sealed")
    if folder is None:
        return make()
    file = folder / name
    with suppress(OSError):
        stored = file.read_bytes()
        content = stored[len(SEAL) + DIGEST :]
        if stored == sealed(name, content):
            return content
    content = make()
    # Where it cannot be kept it is made again by the next report.
    with suppress(OSError):
        aside = file.with_name(f"{name}.{os.getpid()}.tmp")
        write_new_file(aside, sealed(name, content))
        aside.replace(file)
    return content
