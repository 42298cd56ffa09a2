"""Compiled kernels, kept between processes and rebuilt when any source they came from changes.

Numba's own file cache does not notice edits in functions that a cached function calls, so each kernel is written as a module
of its own into a folder whose name is a hash of every model source that went into it and of the library versions.
"""

import hashlib
import importlib.util
import os
import sys
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import Any

COMPILERS = ("numba", "llvmlite", "numpy")


def cache_folder() -> Path:
    """Folder of compiled kernels: TUNER_CACHE_DIR, else the user's cache folder."""
    chosen = os.environ.get("TUNER_CACHE_DIR")
    if chosen:
        return Path(chosen)
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "holdfast" / "kernels"


def fingerprint(source: str, files: Iterable[Path]) -> str:
    """Return the hash of a kernel: its own source, the files of all functions in it and the compilers' versions."""
    digest = hashlib.blake2b(digest_size=12)
    digest.update(source.encode())
    digest.update(" ".join(f"{name}-{version(name)}" for name in COMPILERS).encode())
    digest.update(sys.version.encode())
    for file in sorted(file for file in files if file.is_file()):
        digest.update(file.name.encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()


def load_kernel(name: str, source: str, names: dict[str, Any], files: Iterable[Path]) -> tuple[ModuleType, bool]:
    """Return the module of a kernel and whether it is compiled already; names: its globals."""
    key = fingerprint(source, files)
    module_name = f"kernel_{name}_{key}"
    file = cache_folder() / key / f"{module_name}.py"
    if module_name in sys.modules:
        return sys.modules[module_name], _is_compiled(file)
    if not file.exists():
        file.parent.mkdir(parents=True, exist_ok=True)
        aside = file.with_suffix(f".{os.getpid()}.tmp")
        aside.write_text(source)
        aside.replace(file)
    spec = importlib.util.spec_from_file_location(module_name, file)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    vars(module).update(names)
    sys.modules[module_name] = module
    spec.loader.exec_module(module)
    return module, _is_compiled(file)


def _is_compiled(file: Path) -> bool:
    return any(file.parent.glob("__pycache__/*.nbc"))
