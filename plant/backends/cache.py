"""Cache of compiled kernels: shared between processes, rebuilt when a source changes.

Numba's own file cache does not notice edits in functions that a cached function calls, loads whatever lies in its folder, and
has every process compile for itself. Here a kernel is named by a hash of its source, of every file that went into it, of what
it is a kernel of and of the compilers; its files are sealed (`plant.backends.sealed`). The source is never read from the cache.

A kernel is one function: everything that it calls is inlined (`forceinline`). Else each kernel would carry copies of what it
calls, optimised in its own way, and the copy that runs would be that of whatever was compiled or loaded first.
"""

import hashlib
import os
import sys
from collections.abc import Iterable
from functools import cache
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import Any

from plant.backends.processor import compiled_for
from plant.backends.sealed import SealedFiles, private_folder

COMPILERS = ("numba", "llvmlite", "numpy")


def cache_folder() -> Path:
    """Folder of compiled kernels: TUNER_CACHE_DIR, else the user's cache folder."""
    chosen = os.environ.get("TUNER_CACHE_DIR")
    if chosen:
        return Path(chosen)
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "gainproof" / "kernels"


def _sealed_folder() -> Path | None:
    """Return the part of the cache folder that is this user's alone; None where there can be none."""
    return _checked(cache_folder() / "sealed")


_checked = cache(private_folder)


def fingerprint(source: str, files: Iterable[Path], of: str = "") -> str:
    """Return the hash of a kernel: its own source, the files of all functions in it, what it is of, the compilers' versions."""
    digest = hashlib.blake2b(digest_size=12)
    digest.update(source.encode() + b"\0" + of.encode() + b"\0")
    digest.update(_compilers().encode())
    digest.update(sys.version.encode())
    # In an order that no folder decides: a study that is copied flies the kernel that is there.
    for name, content in sorted((file.name, file.read_bytes()) for file in files if file.is_file()):
        digest.update(name.encode() + b"\0" + content)
    return digest.hexdigest()


@cache
def _compilers() -> str:
    """Return the names and versions of the compilers; to read a version takes 0.7 ms."""
    return " ".join(f"{name}-{version(name)}" for name in COMPILERS)


def load_kernel(
    name: str, source: str, names: dict[str, Any], files: Iterable[Path], of: str = "", kind: Any = None
) -> tuple[ModuleType, bool]:
    """Return the module of a kernel, with its entry `run`, and True if compiled.

    Args:
        name: name of the kernel, for people.
        source: source of the module.
        names: its globals.
        files: files whose content decides what is compiled.
        of: `identity` of the model in it.
        kind: kind of numba's caches, see `keep`; False for none.
    """
    key = fingerprint(source, files, of)
    module_name = f"kernel_{name}_{key}"
    if module_name not in sys.modules:
        module = ModuleType(module_name)
        vars(module).update(names)
        sys.modules[module_name] = module
        exec(compile(source, f"<{module_name}>", "exec"), vars(module))
        if kind is not False:
            keep(module.run, module_name, kind)
    module = sys.modules[module_name]
    return module, is_compiled(module.run)


def keep(dispatcher: Any, name: str, kind: Any = None) -> Any:
    """Cache the compiled code of a function under a name that holds all its inputs; return the function.

    kind: numba's class for caches of such functions, by default that of the processor, whose kernels one process compiles.
    """
    from numba.core.caching import FunctionCache

    parent: Any = kind or FunctionCache
    parts = {"_impl_class": _in_cache_folder(parent._impl_class)} | ({} if kind else {"load_overload": _load_alone})
    numba_cache = type("Kept", (parent,), parts)(dispatcher.py_func)
    numba_cache._cache_file = SealedFiles(_sealed_folder, lambda: f"{name}-{compiled_for().label}", alone=kind is None)
    dispatcher._cache = numba_cache
    return dispatcher


def _load_alone(numba_cache: Any, signature: Any, target: Any) -> Any:
    """Load what numba compiled for a signature, in place of `FunctionCache.load_overload`; None where there is nothing.

    That one first reads all declarations that numba compiles by, 0.5 s of each process; they are read when something is compiled.
    """
    from numba.core.runtime.nrt import rtsys

    # Memory of arrays, which loaded code asks for.
    rtsys.initialize(target)
    with numba_cache._guard_against_spurious_io_errors():
        return numba_cache._load_overload(signature, target)


def keep_file(dispatcher: Any, *files: Path) -> Any:
    """`keep` a function that some files hold with all its callees; return it."""
    function = dispatcher.py_func
    return keep(dispatcher, f"{function.__name__}-{fingerprint(function.__qualname__, files)}")


def is_compiled(dispatcher: Any) -> bool:
    """Return True if a cached function was ever compiled: by this process or an earlier one."""
    files = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
    return isinstance(files, SealedFiles) and (bool(dispatcher.overloads) or any(files.entries()))


def _in_cache_folder(parts: Any) -> Any:
    """Return numba's class for the parts of a cache, bound to `_CacheFolder`."""
    return type("Parts", (parts,), {"_locator_classes": [_CacheFolder]})


class _CacheFolder:
    """Tells numba the folder of the cache; `SealedFiles` does all the rest."""

    def __init__(self, file: str) -> None:
        self._py_file = file

    @classmethod
    def from_function(cls, _: Any, file: str) -> "_CacheFolder":
        """Return the place for a function of a file."""
        return cls(file)

    def get_cache_path(self) -> str:
        """Return the folder."""
        return str(cache_folder())

    def get_source_stamp(self) -> None:
        """Return nothing: names say all."""

    def get_disambiguator(self) -> str:
        """Return nothing."""
        return ""

    def ensure_cache_path(self) -> None:
        """Do nothing: the folder is made and checked where it is used."""
