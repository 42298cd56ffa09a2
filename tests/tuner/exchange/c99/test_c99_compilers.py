"""What compilers say of the exported C: no warning, no double precision in float, nothing called but sqrt, no globals written."""

import subprocess
from pathlib import Path

import pytest

from plant.law_registry import LAWS
from tests.clients import program
from tests.tuner.exchange.c99.compiled import FLAGS, STRICT, uneven
from tuner.exchange.c99.quadrotor import c_sources

CPU = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16")
CASES = {f"{law}_{real}": (uneven(law, law), real) for law in LAWS for real in ("float", "double")}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Header and source of all laws, each under its own prefix."""
    folder = tmp_path_factory.mktemp("c99")
    for prefix, (controller, real) in CASES.items():
        code = c_sources(controller, real, prefix)
        (folder / f"{code.name}.h").write_text(code.header)
        (folder / f"{code.name}.c").write_text(code.source)
    return folder


def sources(real):
    return [f"{name}_controller.c" for name, case in CASES.items() if case[1] == real]


def compile_all(folder, compiler, *flags, real="float", into, chosen=None):
    target = Path(folder) / into
    target.mkdir(exist_ok=True)
    names = [f"../{name}" for name in chosen or sources(real)]
    done = subprocess.run([program(compiler), *flags, "-c", *names], cwd=target, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
    return target


def symbols(nm, folder):
    lines = subprocess.run([program(nm), *sorted(map(str, folder.glob("*.o")))], capture_output=True, text=True).stdout
    return [line.split()[-2:] for line in lines.splitlines() if len(line.split()) >= 2]


@pytest.mark.slow
@pytest.mark.parametrize("real", ["float", "double"])
def test_gcc_has_nothing_to_say(folder, real):
    target = compile_all(folder, "gcc", *FLAGS, *STRICT, "-Wshadow", "-pedantic", real=real, into=f"gcc_{real}")
    undefined = {name for kind, name in symbols("nm", target) if kind == "U"}
    assert undefined <= {"memcpy", "_GLOBAL_OFFSET_TABLE_"}


@pytest.mark.slow
def test_arm_gcc_has_nothing_to_say_and_floats_stay_floats(folder):
    target = compile_all(folder, "arm-none-eabi-gcc", *CPU, *FLAGS, *STRICT, into="arm")
    found = symbols("arm-none-eabi-nm", target)
    assert {name for kind, name in found if kind == "U"} <= {"memcpy"}
    # Neither data that is written nor data that starts as zero: constants only.
    assert not [name for kind, name in found if kind in "bBdDC"]
    public = {name for kind, name in found if kind == "T"}
    entry_points = ("init", "step", "attitude_init", "attitude_step", "measure")
    assert public == {
        f"{prefix}_{name}" for prefix, case in CASES.items() if case[1] == "float" for name in entry_points
    }


def test_the_header_is_cpp(folder):
    """A C++ unit takes the headers and calls the C; -Wold-style-cast and the like are for our own code only."""
    lines = [f'#include "{name}_controller.h"' for name in CASES]
    lines += ["int main() {", *[f"    (void){name}_step;" for name in CASES], "    return 0;", "}"]
    (folder / "all.cpp").write_text("\n".join(lines))
    done = subprocess.run(
        [program("g++"), "-std=c++11", "-Wall", "-Wextra", "-Werror", "-c", "all.cpp"],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr[-2000:]


@pytest.mark.slow
@pytest.mark.parametrize("compiler", ["g++", "clang++"])
@pytest.mark.parametrize("real", ["float", "double"])
def test_the_source_is_cpp(folder, compiler, real):
    """Names of a C unit and of a C++ unit are the same: the header asks for C linkage."""
    target = compile_all(
        folder,
        compiler,
        "-x",
        "c++",
        "-std=c++11",
        "-O2",
        "-Wall",
        "-Wextra",
        "-Werror",
        real=real,
        into=f"{compiler}_{real}",
    )
    assert {"pid_float_step", "pid_double_step"} & {name for kind, name in symbols("nm", target) if kind == "T"}


FAST = (
    "-ffast-math",
    "-Ofast",
    "-ffinite-math-only",
    "-freciprocal-math",
    "-fassociative-math -fno-signed-zeros -fno-trapping-math",
)


@pytest.mark.parametrize(
    ("compiler", "flags"), [("gcc", one) for one in FAST] + [("clang", "-ffast-math"), ("g++", "-x c++ -Ofast")]
)
def test_fast_math_does_not_build(folder, compiler, flags):
    done = subprocess.run(
        [program(compiler), *flags.split(), "-c", "pid_float_controller.c", "-o", "none.o"],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert done.returncode != 0 and "compile this file without -ffast-math" in done.stderr, done.stderr[-2000:]


@pytest.mark.parametrize("real", ["float", "double"])
def test_extended_precision_does_not_build(folder, real):
    """The x87 unit works in 80 bits: other bits than the golden vectors, at the compiler's choice."""
    done = subprocess.run(
        [program("gcc"), "-mfpmath=387", "-c", f"pid_{real}_controller.c", "-o", "none.o"],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert done.returncode != 0 and f"{real} must be worked out as {real}" in done.stderr, done.stderr[-2000:]


def test_contraction_is_what_the_flag_is_for(folder):
    """With gcc's default a Cortex-M4F joins multiply and add; with the flag it never does."""
    one = ["pid_float_controller.c"]
    plain = compile_all(folder, "arm-none-eabi-gcc", *CPU, "-std=gnu99", "-O2", into="contracted", chosen=one)
    exact = compile_all(folder, "arm-none-eabi-gcc", *CPU, *FLAGS, into="exact", chosen=one)
    for target, fused in ((plain, True), (exact, False)):
        code = subprocess.run(
            [program("arm-none-eabi-objdump"), "-d", "pid_float_controller.o"],
            cwd=target,
            capture_output=True,
            text=True,
        )
        assert ("vfma" in code.stdout or "vfms" in code.stdout) == fused
