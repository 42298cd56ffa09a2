"""Compiled kernels: found again by the next process, compiled by one, healed where damaged, and the same bits in all."""

import os
import re
import subprocess
import sys
import threading
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from types import FunctionType
from typing import Any

import pytest

from objectives.margins import curve
from plant.air.linear_process import _recursion
from plant.backends import cache, lanes, sealed
from plant.backends.cache import cache_folder
from plant.records import record_type
from tests.plant.loops import NOMINAL, flyer, gains, inputs, loop

ROOT = Path(__file__).parents[3]

SECOND_PROCESS = """
from tests.plant.loops import NOMINAL, flyer, gains, inputs
assert flyer().cached
flyer().fly(gains()[None], NOMINAL, inputs(range(1)))
run = flyer()._kernel
import sys
print(sum(run.stats.cache_hits.values()), sum(run.stats.cache_misses.values()), "numba.cpython.heapq" in sys.modules)
"""

KEY = """
from plant.backends import lanes
from tests.plant.loops import loop
print(lanes.kernel_of(loop()).run.__module__)
"""

# A function as small as can be, so that it is compiled in a fraction of a second.
KERNEL = """
from pathlib import Path
import numba
from plant.backends.cache import is_compiled, keep_file
def twice(x):
    return 2.0 * x
twice = keep_file(numba.njit(twice), Path("given/by/the/test"))
words = is_compiled(twice), twice(float(21)), sum(twice.stats.cache_misses.values())
"""
SMALL = f"{KERNEL}print(*words)"

# Random loops of ten modes, read by both entries; argument: the order in which they are called first.
CURVES = """
import hashlib, sys
import numpy as np
from objectives.margins import curve
random, h, n, channels = np.random.default_rng(5), 0.004, 200, 2
radius = 1.0 - 10.0 ** random.uniform(-3.0, -0.3, (n, 5))
upper = radius * np.exp(1j * random.uniform(0.001, 1.5, (n, 5)))
weight = (random.normal(size=(n, channels, 5)) + 1j * random.normal(size=(n, channels, 5))) * 0.05 * (1.0 - radius)[:, None]
poles, residues = (np.concatenate([half, half.conj()], axis=-1) for half in (upper, weight))
w = np.concatenate([[0.0], np.geomspace(0.01, 0.9999 * np.pi / h, 200), [np.pi / h]])
grid, stable = np.stack([w, np.cos(w * h), np.sin(w * h)]), np.ones(n, dtype=bool)
found = [np.zeros((n, channels, *shape)) for shape in ((3, 2), (2, 12, 2), ())]
calls = [
    lambda: curve.read_all(grid, poles, residues, stable, h, np.array([1.0, 0.0, 0.5]), *found[:2], True, True),
    lambda: curve.highest_crossings(grid, poles, residues, stable, h, 0.5, found[2]),
]
for i in map(int, sys.argv[1]):
    calls[i]()
print(hashlib.sha256(b"".join(entry.tobytes() for entry in found)).hexdigest(), found[0].sum() > 0)
"""


def start(code, cache=None, *arguments, before=""):
    # Numba's own folder too, in case that something still uses it.
    own = {} if cache is None else {"TUNER_CACHE_DIR": str(cache), "NUMBA_CACHE_DIR": str(cache)}
    return subprocess.Popen(
        [sys.executable, "-c", f"import sys; sys.path.insert(0, '.')\n{before}\n{code}", *arguments],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | own,
    )


def end(process):
    """Return the words that a process printed, and the lines that it said."""
    out, said = process.communicate(timeout=300)
    assert process.returncode == 0, said
    return out.split(), said.splitlines()


def run(code, *arguments, **named):
    return end(start(code, *arguments, **named))


@pytest.fixture
def small(tmp_path, monkeypatch, capsys):
    """A function that runs SMALL here as a process would that has loaded nothing; returns its words, and the lines that it said."""

    def ask(folder=tmp_path):
        cache._checked.cache_clear()
        sealed.say.cache_clear()
        monkeypatch.setenv("TUNER_CACHE_DIR", str(folder))
        names = {"__name__": "__main__"}
        exec(compile(KERNEL, "<string>", "exec"), names)
        return [str(word) for word in names["words"]], capsys.readouterr().err.splitlines()

    return ask


def kept(folder):
    (file,) = folder.rglob("*.kernel")
    return file


def test_second_process_compiles_nothing():
    flyer().fly(gains()[None], NOMINAL, inputs(range(1)))
    # Nor does it read the declarations that numba compiles by, heaps among them.
    assert run(SECOND_PROCESS) == (["1", "0", "False"], [])


def test_the_key_is_the_same_in_every_process():
    assert run(KEY)[0] == [lanes.kernel_of(loop()).run.__module__]


def test_the_folder_can_be_chosen(monkeypatch, tmp_path):
    monkeypatch.setenv("TUNER_CACHE_DIR", str(tmp_path))
    assert cache_folder() == tmp_path


# The same bits


@pytest.mark.slow
def test_the_process_that_compiles_gives_the_bits_of_those_that_load_in_any_order(tmp_path):
    """In small: the test below, for the reason, and the first run of a fresh install, whose bytes are those of the second."""
    first = run(CURVES, tmp_path, "01")
    assert first[0][1] == "True"
    assert run(CURVES, tmp_path, "01") == first
    assert run(CURVES, tmp_path, "10") == first


def test_nothing_but_the_entry_of_a_kernel_computes():
    # Another function in a kernel is a copy that some other kernel may have too, optimised in another way; which of them runs
    # would hang on what was loaded first. (What writes the text of an error computes too.)
    flyer().fly(gains()[None], NOMINAL, inputs(range(1)))
    entries: list[Any] = [flyer()._kernel, _recursion(), *([curve.read_all] if curve.read_all.overloads else [])]
    for entry in entries:
        (compiled,) = entry.overloads.values()
        module = compiled.library._get_module_for_linking()
        defined = [part for part in module.functions if not part.is_declaration and "_raise_" not in part.name]
        computing = [part.name for part in defined if re.search(r"= f(add|sub|mul|div) ", str(part))]
        assert computing == [compiled.fndesc.llvm_func_name]


# Damage


def flipped(content):
    return content[:100] + bytes([content[100] ^ 4]) + content[101:]


DAMAGE = {
    "flipped": flipped,
    "cut": lambda content: content[: len(content) // 2],
    "empty": lambda _: b"",
    "foreign": lambda _: b"cos\nsystem\n(S'exit 3'\ntR.",
}


def test_a_damaged_kernel_is_compiled_again_with_one_line(tmp_path, small):
    assert small()[0] == ["False", "42.0", "1"]
    assert small() == (["True", "42.0", "0"], [])
    for damage in DAMAGE.values():
        file = kept(tmp_path)
        file.write_bytes(damage(file.read_bytes()))
        told, said = small()
        assert told == ["False", "42.0", "1"]
        assert said == [f"{file} is damaged; the kernel is compiled again."]
    assert small() == (["True", "42.0", "0"], [])


def test_a_sealed_file_under_another_name_is_damaged(tmp_path, capsys):
    (tmp_path / "b").write_bytes(sealed.sealed("a", b"content"))
    assert sealed.unsealed(tmp_path / "b") is None
    assert "is damaged" in capsys.readouterr().err
    (tmp_path / "a").write_bytes(sealed.sealed("a", b"content"))
    assert sealed.unsealed(tmp_path / "a") == b"content"


@pytest.mark.parametrize("damage", ["writable folder", "writable file"])
def test_what_others_can_write_is_not_executed(tmp_path, small, damage):
    small()
    file = kept(tmp_path)
    assert (file.parent.stat().st_mode & 0o777, file.stat().st_mode & 0o777) == (0o700, 0o600)
    spoilt = file if damage == "writable file" else file.parent
    spoilt.chmod(0o777)
    told, said = small()
    assert told == ["False", "42.0", "1"]
    assert len(said) == 1 and said[0].startswith(str(spoilt)) and "can be written by other users" in said[0]


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only root can give a folder away")
def test_a_folder_of_somebody_else_is_not_used(tmp_path, small):
    small()
    os.chown(kept(tmp_path).parent, 12345, 12345)
    told, said = small()
    assert told == ["False", "42.0", "1"]
    assert len(said) == 1 and "belongs to another user" in said[0]


@pytest.mark.slow
def test_without_a_folder_or_room_on_the_disk_each_process_compiles_its_own(tmp_path, small):
    (tmp_path / "file").write_text("")
    told, said = small(tmp_path / "file")
    assert told == ["False", "42.0", "1"] and len(said) == 1 and "compiled kernels are not kept" in said[0]
    full = "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
    full += "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))"
    told, said = run(SMALL, tmp_path, before=full)
    assert told == ["False", "42.0", "1"] and len(said) == 1 and "cannot be written (File too large)" in said[0]
    assert not [file for file in tmp_path.rglob("*") if file.suffix in (".tmp", ".kernel")]


# One process compiles


@pytest.mark.slow
def test_one_of_several_processes_compiles(tmp_path):
    together = [end(process) for process in [start(SMALL, tmp_path) for _ in range(3)]]
    assert sorted(told[2] for told, _ in together) == ["0", "0", "1"]
    assert {told[1] for told, _ in together} == {"42.0"}


def test_a_process_that_waits_for_the_compiler_of_another_says_so(tmp_path, small):
    fcntl = pytest.importorskip("fcntl")
    small()
    file = kept(tmp_path)
    content = file.read_bytes()
    file.unlink()
    with file.with_suffix(".lock").open("r+b") as holder:
        fcntl.flock(holder, fcntl.LOCK_EX)
        waiting = start(SMALL, tmp_path)
        killer = threading.Timer(60.0, waiting.kill)
        killer.start()
        assert waiting.stderr is not None
        assert waiting.stderr.readline() == "Another process is compiling this kernel; waiting for it.\n"
        killer.cancel()
        file.write_bytes(content)
    assert end(waiting)[0] == ["False", "42.0", "0"]


# What a key holds


def varied(value):
    """Return something that differs a little from a part of a closed loop, under the same name."""
    if isinstance(value, FunctionType):
        other = FunctionType(
            value.__code__.replace(co_consts=(*value.__code__.co_consts, 1.5)),
            value.__globals__,
            value.__name__,
            value.__defaults__,
            value.__closure__,
        )
        other.__qualname__ = value.__qualname__
        return other
    if isinstance(value, type):
        fewer = dict(list(value.__annotations__.items())[:-1])
        other = record_type(value.__name__, {"other": float, **fewer})
        other.__qualname__, other.__module__ = value.__qualname__, value.__module__
        return other
    if is_dataclass(value) and not isinstance(value, type):
        name = fields(value)[0].name
        return replace(value, **{name: varied(getattr(value, name))})
    return f"{value} varied"


def test_every_part_of_a_loop_is_in_the_key_of_its_kernel():
    # A part that `varied` does not know fails here, so that a new one cannot be forgotten.
    known, one = lanes.kernel_of(loop()).run, loop()
    assert lanes.kernel_of(replace(one)).run is known
    others = {field.name: replace(one, **{field.name: varied(getattr(one, field.name))}) for field in fields(one)}
    for field in fields(one.cascade):
        other = replace(one.cascade, **{field.name: varied(getattr(one.cascade, field.name))})
        others[f"cascade.{field.name}"] = replace(one, cascade=other)
    for name, part in one.records._asdict().items():
        other = part - 1 if isinstance(part, int) else varied(part)
        others[f"records.{name}"] = replace(one, records=one.records._replace(**{name: other}))
    del others["records"]
    assert {"advance", "cascade.prepare", "records.Gains", "records.n_wind_leaves"} < set(others)
    broken = set()
    for name, other in others.items():
        try:
            assert lanes.kernel_of(other).run is not known, name
        except (AttributeError, IndexError):
            broken.add(name)
    # No kernel is made of a loop whose records are not those that its functions fill.
    assert broken <= {"Flight"}
    assert lanes.kernel_of(replace(one)).run is known
