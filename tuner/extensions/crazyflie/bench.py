"""The Crazyflie's controllers on the bench: where the module and its Python are, and what the file of the gains sets in it.

Facts of crazyflie-firmware of 2026: bindings/setup.py, src/modules/src/stabilizer.c and controller/attitude_pid_controller.c.
"""

import re
import shutil
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

from plant.errors import InputError
from tuner.extensions.autopilots.firmware import Bench, Firmware, period_check
from tuner.extensions.autopilots.firmware_parameters import parameters_in
from tuner.extensions.autopilots.process import BUILT
from tuner.extensions.crazyflie.board import CrazyflieBoard
from tuner.extensions.crazyflie.stabilizer import ATTITUDE_RATE, SETTABLE

MODULES, MODULE = "_cffirmware*.so", "cffirmware.py"
# The Python that a module was built for.
TAG = re.compile(r"\.cpython-(\d)(\d+)\w*[-.]")
VALUE = re.compile(r"  (\w+\.\w+): \{is_stored: true, default_value: \S+, stored_value: (-?[\d.]+)\}")
HEADING = re.compile(r"#|type: |version: |params:\Z|\Z")
POSITION = ("posCtlPid.", "velCtlPid.")
"""Groups of the position loops, in whose place ours are."""


def module_in(given: Path) -> Path:
    """Return a build folder's compiled module, or the given file; raises InputError where there is none or many."""
    if not given.is_dir():
        return given
    modules = sorted(given.glob(MODULES))
    if len(modules) == 1:
        return modules[0]
    names = ", ".join(path.name for path in modules) or "none"
    raise InputError(f"holds {names}; one {MODULES} is needed; {BUILT}", file=given, key="--binary")


def interpreter_for(module: Path) -> Path:
    """Return a Python of the version that a module was built for; raises InputError where there is none."""
    tag = TAG.search(module.name)
    if tag is None or (int(tag[1]), int(tag[2])) == sys.version_info[:2]:
        return Path(sys.executable)
    name = f"python{tag[1]}.{tag[2]}"
    interpreter = shutil.which(name)
    if interpreter is None:
        raise InputError(
            f"cannot be run: it was built for Python {tag[1]}.{tag[2]}, and there is no {name} on the path; build it with "
            f"{sys.executable}, or put that Python on the path",
            file=module,
            key="--binary",
        )
    return Path(interpreter)


def parameters_of(content: bytes) -> dict[str, float]:
    """Return the parameters of an exported file without the position loops; raises InputError naming what cannot be set."""
    parameters = parameters_in(content, VALUE, HEADING, POSITION)
    for name in parameters.keys() - SETTABLE:
        raise InputError("the Python module of the firmware has nothing that sets this parameter", key=name)
    return parameters


def install(bench: Bench, content: bytes) -> Callable[[], CrazyflieBoard]:
    """Try the module with the parameters of the file."""
    try:
        for path in (bench.binary, bench.binary.with_name(MODULE)):
            path.stat()
    except OSError as error:
        raise InputError(f"cannot be run: {error.strerror}; {BUILT}", file=error.filename, key="--binary") from None
    power_up = partial(CrazyflieBoard, interpreter_for(bench.binary), bench.binary, parameters_of(content))
    power_up().close()
    return power_up


CRAZYFLIE = Firmware(
    name="crazyflie",
    title="Crazyflie",
    target="crazyflie",
    file="gainproof_params.yaml",
    law="crazyflie",
    heading=None,
    curve=0.0,
    binary="the folder with the Python module of its controllers, or the module",
    check=period_check(
        lambda period: period * ATTITUDE_RATE, 1, 1, f"the Crazyflie's controllers run each {1e3 / ATTITUDE_RATE:g} ms"
    ),
    program=module_in,
    install=install,
    lockstep=True,
    loses=(
        "Outputs of the loops are whole counts of 32767, motor commands whole counts of 65535; all else is float32.",
        "The gyro is filtered each 1 ms: each sample of ours is read twice.",
        "Thrust is taken as proportional to counts, as the firmware's battery compensation makes it; the module has none.",
        "The position loops are ours: the file's posCtlPid and velCtlPid are not loaded.",
    ),
)
