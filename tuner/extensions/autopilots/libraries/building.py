"""Control libraries of a firmware, compiled from its checkout around our program."""

import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path

from plant.backends.cache import cache_folder
from plant.backends.sealed import private_folder
from plant.errors import InputError, shortened
from plant.own_code import refuse_program
from tuner.extensions.autopilots.process import BINARY, BUILT

# One step is equal on every machine that computes by IEEE 754: no operation is contracted.
OPTIONS = ("-std=gnu++17", "-O2", "-DNDEBUG", "-w", "-ffp-contract=off")


@dataclass(frozen=True)
class ControlLibraries:
    """Control libraries of a firmware.

    Attributes:
        name: Short name of the firmware.
        checkout: Description of the folder.
        source: Our program, which includes the libraries' sources.
        middleware: Interface to the firmware's other parts, included before all else.
        empty: Headers of those parts, which are read as empty.
        folders: Folders of the checkout in which headers and sources are looked for.
        marker: A file that every checkout has.
    """

    name: str
    checkout: str
    source: Path
    middleware: Path
    empty: tuple[str, ...]
    folders: tuple[str, ...]
    marker: str

    def program(self, given: Path) -> Path:
        """Return the program of a checkout, compiled now, or the given file; raises InputError where it cannot be compiled."""
        if not given.is_dir():
            return given
        if not (given / self.marker).is_file():
            raise InputError(f"holds no {self.marker}; give {self.checkout}; {BUILT}", file=given, key="--binary")
        folder = private_folder(cache_folder() / "firmware")
        if folder is None:
            raise InputError("no folder of this user's own is left for compiled programs; set TUNER_CACHE_DIR")
        program = folder / f"{self.name}-{blake2b(os.fsencode(given.resolve()), digest_size=8).hexdigest()}"
        with tempfile.TemporaryDirectory(dir=folder) as place:
            self.compile(given, Path(place) / "program").replace(program)
        return program

    def compile(self, checkout: Path, program: Path, options: Sequence[str] = ()) -> Path:
        """Compile a checkout with further options of the compiler; return the program."""
        refuse_program(checkout, BINARY)
        compiler, sources = shutil.which("g++") or shutil.which("c++"), checkout.resolve()
        if compiler is None:
            raise InputError(f"no C++ compiler (g++, c++) is installed; it compiles the loops of {self.checkout}")
        with tempfile.TemporaryDirectory(prefix="gainproof-") as place:
            for name in self.empty:
                header = Path(place) / name
                header.parent.mkdir(parents=True, exist_ok=True)
                header.touch()
            ours = [Path(place), self.source.parent, Path(__file__).parent]
            folders = [f"-I{folder}" for folder in (*ours, *(sources / folder for folder in self.folders))]
            first = ["-include", str(self.middleware), f"-ffile-prefix-map={sources}=."]
            command = [compiler, *OPTIONS, *options, *first, *folders, str(self.source), "-o", str(program)]
            done = subprocess.run(command, capture_output=True, encoding="utf-8", errors="replace", check=False)
        if done.returncode != 0:
            lines = done.stderr.splitlines()
            problem = next((line for line in lines if "error" in line), "".join(lines[-1:]))
            raise InputError(
                f"its control libraries cannot be compiled: {shortened(problem, 300)}; {BUILT}",
                file=checkout,
                key="--binary",
            )
        return program
