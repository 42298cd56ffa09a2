"""FMUs for tests: the motor of motor.c, compiled for FMI 2 or 3, with faults, and descriptions that can be changed."""

import subprocess
import zipfile
from functools import cache
from importlib import import_module
from pathlib import Path
from tempfile import mkdtemp

from tests.clients import program
from tuner.extensions.fmu.archive import platform_folder

SOURCE = Path(__file__).with_name("motor.c")
# Name, value reference, causality, unit and start of each variable; then what else its element has.
VARIABLES = (
    ("angle", 0, "output", "rad", 0.0), ("motor.speed", 1, "local", "rad/s", 0.0), ("der(angle)", 2, "local", "rad/s", None),
    ("der(motor.speed)", 3, "local", "rad/s2", None), ("voltage", 4, "input", "V", 0.0), ("torque", 5, "input", "N m", 0.0),
    ("inertia", 6, "parameter", "kg m2", 3.2284e-6), ("friction", 7, "parameter", "N m s", 3.5077e-6),
    ("constant", 8, "parameter", "N m/A", 0.0274), ("resistance", 9, "parameter", "Ohm", 4.0),
    ("fault", 10, "parameter", "rad", 0.0),
)  # fmt: skip
RATES = {2: 0, 3: 1}
"""State of each derivative, by value references."""


@cache
def library(version: int, *options: str) -> bytes:
    """Return the machine code of the motor."""
    out = Path(mkdtemp(prefix="motor-")) / "motor.so"
    stubs = out.with_name("stubs.c")
    stubs.write_text("".join(f"int {name}(void) {{ return 3; }}\n" for name in unused(version)))
    files = [str(SOURCE), str(stubs), "-o", str(out), "-lm"]
    command = [program("gcc"), "-O1", "-shared", "-fPIC", f"-DFMI={version}", *options, *files]
    subprocess.run(command, check=True, capture_output=True)
    return out.read_bytes()


def unused(version: int) -> list[str]:
    """Return the functions of the standard that the motor has no use for: they return an error."""
    unit = getattr(import_module(f"fmpy.fmi{version}"), f"FMU{version}Slave")
    written = SOURCE.read_text()
    return [
        name for name in dir(unit) if name.startswith(f"fmi{version}") and f" {name}(" not in written.replace("*", " ")
    ]


def description(version: int, *, directional: bool = True, states: bool = True) -> str:
    """Return its modelDescription.xml."""
    two = version == 2
    token = 'guid="motor-token"' if two else 'instantiationToken="motor-token"'
    gives = f'providesDirectionalDerivative{"" if two else "s"}="{str(directional).lower()}"'
    rates = "".join(_rate(version, reference) for reference in RATES) if states else ""
    structure = f"<Derivatives>{rates}</Derivatives>" if two else rates
    return (
        f'<fmiModelDescription fmiVersion="{version}.0" modelName="Motor" description="Angle of a DC motor" {token}>'
        f'<CoSimulation modelIdentifier="motor" {gives}/><ModelVariables>{"".join(_variable(version, *each) for each in VARIABLES)}'
        f"</ModelVariables><ModelStructure>{structure}</ModelStructure></fmiModelDescription>"
    )


def _rate(version: int, reference: int) -> str:
    return (
        f'<Unknown index="{reference + 1}"/>'
        if version == 2
        else f'<ContinuousStateDerivative valueReference="{reference}"/>'
    )


def _variable(version: int, name: str, reference: int, causality: str, unit: str, start: float | None) -> str:
    state = RATES.get(reference)
    rate = "" if state is None else f' derivative="{state + 1 if version == 2 else state}"'
    real = f'unit="{unit}"{rate}' + ("" if start is None else f' start="{start!r}"')
    fixed = ' variability="fixed"' if causality == "parameter" else ""
    head = f'name="{name}" valueReference="{reference}" causality="{causality}"{fixed}'
    return f"<ScalarVariable {head}><Real {real}/></ScalarVariable>" if version == 2 else f"<Float64 {head} {real}/>"


def write_motor(
    folder: Path, version: int, *options: str, name: str = "motor", text: str | None = None, **changes: bool
) -> Path:
    """Write the FMU of the motor; options: of the compiler; text: in place of its description."""
    file = folder / f"{name}.fmu"
    content = {
        "modelDescription.xml": (text or description(version, **changes)).encode(),
        f"binaries/{platform_folder(version)}/motor.so": library(version, *options),
    }
    return write_archive(file, content)


def write_archive(file: Path, content: dict[str, bytes]) -> Path:
    """Write an archive of these files."""
    with zipfile.ZipFile(file, "w") as archive:
        for name, part in content.items():
            archive.writestr(name, part)
    return file
