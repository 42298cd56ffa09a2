"""Code of the user's own: a file of a law, a metric or a reference, run in this process from the bytes that were read.

The digest of a file is taken over its bytes and those of the files next to it that it imports, which are run before it. Code that
has run is known by its digest: a copy of it elsewhere, such as in a results folder, is the same code and is not run again.

Code that is found through a study runs where the study is no results folder's and the code lies with it: in the folder of the
study, below that, or below the working folder. Other code runs only where the user names it.
"""

import ast
import hashlib
import os
import sys
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from traceback import walk_tb
from types import ModuleType
from typing import Any, NamedTuple

from plant.errors import InputError, UnnamedCodeError
from plant.input_files import MAX_TEXT_BYTES, given_content
from plant.origin import Origin
from plant.results_folder import in_results_folder

# Largest FMU [bytes].
MAX_BINARY_BYTES = 2**29


class Source(NamedTuple):
    """A file as it was read."""

    file: Path
    content: bytes


@dataclass(frozen=True)
class OwnCode:
    """Code that has run. names: what its file defines."""

    file: Path
    digest: str
    names: Mapping[str, Any]

    @property
    def origin(self) -> Origin:
        """File and digest."""
        return Origin(str(self.file), self.digest)


OWN_CODE = "TUNER_OWN_CODE"
"""Environment variable; "refuse" disables user code."""
NOT_RUN = "which this process does not run; `tuner mcp --allow-code` would"
HAVE_RUN: dict[str, OwnCode] = {}
"""All code of the user's that has run in this process, by digest."""
ANNOUNCEMENTS: list[Callable[[str, str], object]] = []
"""Functions that get the digest of code that a study names, and a sentence on it, before it runs."""
_files: set[str] = set()


def run_own_code(file: Path, study: Path | None = None) -> OwnCode:
    """Run a file, once for a digest; study: the file that names it, None where the user does.

    Raises UnnamedCodeError for code of a results folder or from elsewhere that no user named, and InputError, with file and
    line, where the code fails.
    """
    sources = sources_of(file)
    digest = digest_of(sources)
    if digest not in HAVE_RUN:
        _admit([source.file for source in sources], file, digest, study)
        HAVE_RUN[digest] = OwnCode(file, digest, _run(sources, digest))
    return HAVE_RUN[digest]


def named_binary(file: Path, study: Path | None = None, most: int = MAX_TEXT_BYTES) -> OwnCode:
    """Return machine code of the user's by its digest; it runs elsewhere. study: as for `run_own_code`.

    Raises UnnamedCodeError as `run_own_code` does, and InputError where the file cannot be read.
    """
    digest = digest_of_bytes(_read(file, most))
    if digest not in HAVE_RUN:
        _admit([file], file, digest, study)
        HAVE_RUN[digest] = OwnCode(file, digest, {})
    return HAVE_RUN[digest]


def refuse_unnamed(file: Path) -> None:
    """Raise UnnamedCodeError for code, or an FMU, that the user has not named."""
    digest = digest_of(sources_of(file)) if file.suffix == ".py" else digest_of_bytes(_read(file, MAX_BINARY_BYTES))
    if digest not in HAVE_RUN:
        raise _unnamed(file, digest, "this is code from elsewhere")


def refuse_program(program: str | Path, key: str) -> None:
    """Raise InputError where this process runs no code: before each start of a program that is no part of this tool.

    Args:
        program: file or command.
        key: option that names it.
    """
    if _runs_none():
        raise InputError(f"is a program, {NOT_RUN}", file=program, key=key)


def _runs_none() -> bool:
    return os.environ.get(OWN_CODE) == "refuse"


def _admit(files: list[Path], main: Path, digest: str, study: Path | None) -> None:
    """Announce code that a study names before its first run; UnnamedCodeError where the user has to name it.

    InputError where this process runs none.
    """
    if _runs_none():
        raise InputError(f"holds code, {NOT_RUN}", file=main)
    if study is None:
        return
    if in_results_folder(study) or any(map(in_results_folder, files)):
        raise _unnamed(main, digest, "this is code in a results folder")
    near = (study.parent.resolve(), Path.cwd())
    for file in files:
        if not any(file.resolve().is_relative_to(folder) for folder in near):
            raise _unnamed(main, digest, f"this code lies outside the folder of {study} and the working folder")
    for announce in ANNOUNCEMENTS:
        announce(digest, f"{study} runs code: {', '.join(str(file) for file in reversed(files))} (digest {digest}).")


def sources_of(file: Path) -> tuple[Source, ...]:
    """Return a file after its imported siblings, each once; InputError where one cannot be read."""
    by_file: dict[Path, Source] = {}
    _collect(file, by_file, set())
    return tuple(by_file.values())


def digest_of(sources: tuple[Source, ...]) -> str:
    """Return the digest of a file and of what it imports; what the file itself is called does not count."""
    *siblings, main = sources
    digest = hashlib.blake2b(main.content, digest_size=12)
    for source in sorted(siblings, key=lambda source: source.file.name):
        digest.update(f"\0{source.file.name}\0{len(source.content)}\0".encode() + source.content)
    return digest.hexdigest()


def digest_of_bytes(content: bytes) -> str:
    """Return the digest of machine code."""
    return hashlib.blake2b(content, digest_size=12).hexdigest()


def place_of_error(error: BaseException) -> str | None:
    """Return the "file:line" of the user's code behind an error, or None."""
    places = [
        f"{frame.f_code.co_filename}:{line}"
        for frame, line in walk_tb(error.__traceback__)
        if frame.f_code.co_filename in _files
    ]
    return places[-1] if places else None


def _collect(file: Path, by_file: dict[Path, Source], begun: set[Path]) -> None:
    """Read a file after all that it imports from its folder."""
    begun.add(file)
    content = _read(file)
    for name in _imported(content):
        sibling = file.parent / f"{name}.py"
        if sibling not in begun and sibling.is_file():
            _collect(sibling, by_file, begun)
    by_file[file] = Source(file, content)


def _read(file: Path, most: int = MAX_TEXT_BYTES) -> bytes:
    what = "a Python file of your own" if file.suffix == ".py" else "a file of your own"
    return given_content(file, f"give {what}", most)


def _imported(content: bytes) -> Iterator[str]:
    """Yield the top-level names that a file imports; none where it is no Python, which running it tells."""
    try:
        tree = ast.parse(content)
    except (SyntaxError, ValueError):
        return
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (entry.name.partition(".")[0] for entry in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module.partition(".")[0]


def _run(sources: tuple[Source, ...], digest: str) -> Mapping[str, Any]:
    """Run files in their order and return what the last one defines; each is a module that later ones can import by its name."""
    importable: dict[str, ModuleType] = {}
    names: Mapping[str, Any] = {}
    for source in sources:
        # By content and not by place, so that kernels of the same code are the same.
        module = ModuleType(f"own_code_{digest}_{len(importable)}")
        module.__file__ = str(source.file)
        sys.modules[module.__name__] = module
        with _standing_in(importable):
            _run_one(source, module)
        importable[source.file.stem] = module
        names = vars(module)
    return names


def _run_one(source: Source, module: ModuleType) -> None:
    file = str(source.file)
    _files.add(file)
    try:
        exec(compile(source.content, file, "exec", dont_inherit=True), vars(module))
    except SyntaxError as error:
        raise InputError(f"{error.msg}; correct this line", file=f"{error.filename}:{error.lineno}") from error
    except InputError:
        raise
    except (Exception, SystemExit) as error:
        what = f"{type(error).__name__}: {error}"
        raise InputError(f"fails when it is read: {what}", file=place_of_error(error) or file) from error


@contextmanager
def _standing_in(modules: Mapping[str, ModuleType]) -> Generator[None]:
    """Have modules imported by their names, whatever else bears them."""
    before = {name: sys.modules.get(name) for name in modules}
    sys.modules.update(modules)
    try:
        yield
    finally:
        for name, module in before.items():
            if module is None:
                del sys.modules[name]
            else:
                sys.modules[name] = module


def _unnamed(file: Path, digest: str, what: str) -> UnnamedCodeError:
    changed = [code for code in HAVE_RUN.values() if code.file.name == file.name]
    if changed:
        return UnnamedCodeError(
            f"the run flew this code (digest {digest}), and {changed[0].file} is another (digest {changed[0].digest}): it has "
            f"changed since; put it back, or name the copy with --code {file}",
            file=file,
        )
    return UnnamedCodeError(
        f"{what} (digest {digest}), which runs only where you name it: look at it, then add --code {file}, or --code and "
        "your own file",
        file=file,
    )
