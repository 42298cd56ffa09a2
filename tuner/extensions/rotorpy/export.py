"""RotorPy: a Python package that flies the gains of any law in that simulator, with the vehicle to fly them on.

The package carries copies of the model functions (`plant`) that the controller calls, so it computes the same bits as our own
simulation, and it needs NumPy only. A RotorPy user would rather copy one folder than install a tuner with its compilers and
solvers into the simulator's environment; and the copy goes on flying as exported when the tuner moves on. Imports inside it are
relative: the folder can be renamed, and two exports be flown side by side.
"""

import ast
import importlib.util
import re
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path

from plant import law_registry
from plant.errors import InputError
from plant.own_code import sources_of
from plant.quadrotor.airframes.rules import hover_speed
from plant.quadrotor.gains import gain_addresses
from tuner.exchange.aboard import rollback_request
from tuner.exchange.target import Bundle, ExportTarget, Request
from tuner.exchange.texts import filled, heading, markdown, python_docstring, tool
from tuner.extensions.rotorpy import controller as rotorpy_controller
from tuner.extensions.rotorpy.vehicle import differences, parameters

PACKAGE = "gainproof_rotorpy"
VERSION = "RotorPy 3.0"
MODULES = ("README.md", *(f"{PACKAGE}/{name}.py" for name in ("__init__", "gains", "vehicle_params")))
# What stands in the packages inside, whose own would import every law.
PART = '"""Copies of gainproof\'s model functions, those that this controller calls."""\n'
CONTROLLER = Path(rotorpy_controller.__file__)
_OURS = re.compile(r"^from (plant|tuner)(\.[\w.]+)? import", re.MULTILINE)
"""Imports of modules that are copied: models, and laws of extensions."""


def export(request: Request) -> Bundle:
    """Write the package; every law can be carried, see `ExportTarget.export`."""
    earlier, sentence = rollback_request(request)
    return Bundle(
        files=package(request),
        rollback=package(earlier, sentence),
        held=request.controller,
        differences=(
            "The command is held over each control period: sim_rate must be a whole multiple of "
            f"{1.0 / request.controller.control_period:g} Hz.",
            "cmd_ctbm is turned into rotor thrusts by RotorPy's vehicle; ours are found again where its rotors are those of "
            "vehicle_params.py.",
            *differences(request.controller.airframe.vehicle),
        ),
        target_version=VERSION,
    )


def package(request: Request, sentence: str = "") -> dict[str, bytes]:
    """Return name -> content of the files of the package."""
    cascade = request.controller.cascade
    files = _modules(request, sentence)
    files[f"{PACKAGE}/flight_controller.py"] = relative(CONTROLLER.read_text(encoding="utf-8"), ".", "")
    files |= {
        f"{PACKAGE}/{name}": text for name, text in copies({cascade.position.name, cascade.attitude.name}).items()
    }
    return {name: text.encode() for name, text in sorted(files.items())}


def copies(names: set[str]) -> dict[str, str]:
    """Return path -> text of the modules that the controller needs: with some laws, and their packages."""
    reached = reach(CONTROLLER, {module_of(name) for name in names})
    texts = {}
    for module in sorted(reached):
        *folders, name = module.split(".")
        text = source(module).read_text(encoding="utf-8")
        texts[f"{'/'.join(folders)}/{name}.py"] = relative(text, "." * len(folders), folders[0])
        texts |= {f"{'/'.join(folders[:depth])}/__init__.py": PART for depth in range(1, len(folders) + 1)}
    return texts


def module_of(law: str) -> str:
    """Return the module of a law; of a user's law, that in the copy."""
    if law_registry.LAWS[law].origin is not None:
        return f"plant.laws.own_{law}"
    return next(module.__name__ for module in law_registry.MODULES if module.LAW is law_registry.LAWS[law])


def reach(file: Path, start: set[str]) -> set[str]:
    """Return the modules of ours that a file and some modules import: the transitive closure."""
    waiting, modules = imports(file) | start, set()
    while waiting:
        module = waiting.pop()
        modules.add(module)
        waiting |= imports(source(module)) - modules
    return modules


def imports(file: Path) -> set[str]:
    """Return the modules of ours that a file imports."""
    return set(_imported(file.read_text(encoding="utf-8")))


@lru_cache(maxsize=256)
def _imported(text: str) -> frozenset[str]:
    """Return the modules of ours that a text imports; cached, for an export and its rollback read the same 25 files."""
    modules = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] in ("plant", "tuner"):
            within = [f"{node.module}.{name.name}" for name in node.names]
            modules |= {name if _is_module(name) else node.module for name in within}
    return frozenset(modules)


def _is_module(name: str) -> bool:
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:
        return False


def source(module: str) -> Path:
    """Return the file of a module; InputError for a user's law in several files."""
    for name, entry in law_registry.LAWS.items():
        if entry.origin is not None and module == f"plant.laws.own_{name}":
            return _single_file(Path(entry.step.__code__.co_filename))
    spec = importlib.util.find_spec(module)
    assert spec is not None and spec.origin is not None, module
    return Path(spec.origin)


def _single_file(file: Path) -> Path:
    siblings = [source.file.name for source in sources_of(file)[:-1]]
    if siblings:
        raise InputError(
            f"imports {', '.join(siblings)} from files next to it; rotorpy takes a law in one file", file=file
        )
    return file


def relative(text: str, dots: str, package: str) -> str:
    """Return a module's text with its imports of ours relative.

    Args:
        text: Text of the module.
        dots: Way up to the outermost of the packages that it lies in.
        package: Name of that package, "" for a module beside the packages.
    """

    def statement(match: re.Match[str]) -> str:
        top, rest = match.group(1), match.group(2) or ""
        return f"from {dots}{rest[1:] if top == package else f'.{top}{rest}' if package else top + rest} import"

    return _OURS.sub(statement, text)


def _modules(request: Request, sentence: str) -> dict[str, str]:
    """Return README.md and the modules that are written again; repr gives every double back as it was."""
    controller = request.controller
    vehicle, cascade = controller.airframe.vehicle, controller.cascade
    position, attitude = module_of(cascade.position.name), module_of(cascade.attitude.name)
    about = heading(request, python_docstring)
    gains = [
        f'    "{gain.address}": {controller.gains[gain.column]!r},  # {gain.unit}' for gain in gain_addresses(cascade)
    ]
    words = {
        "tool": tool(),
        "package": PACKAGE,
        "laws": about[2],
        "heading": "\n".join(about),
        "lines": "\n".join([*(f"{line}." for line in about), *([python_docstring(sentence)] if sentence else [])]),
        "introduction": "\n".join(
            [*(f"{line}.  " for line in heading(request, markdown)), *([markdown(sentence)] if sentence else [])]
        ),
        "imports": "\n".join(_import_of(name) for name in sorted({position, attitude})),
        "gains": "\n".join(gains),
        "position": position.rpartition(".")[-1],
        "attitude": attitude.rpartition(".")[-1],
        "every": repr(cascade.position_every),
        "options": ", ".join(f"{name}={value!r}" for name, value in asdict(controller.options).items()),
        "vehicle": repr(vehicle),
        "period": repr(controller.control_period),
        "rate": f"{1.0 / controller.control_period:g}",
        "parameters": "\n".join(f'    "{name}": {value!r},' for name, value in parameters(vehicle).items()),
        "rotors": "\n".join(
            f'        "r{i}": np.array([{x!r}, {y!r}, {vehicle.drag_height!r}]),'
            for i, (x, y) in enumerate(zip(vehicle.rotor_x, vehicle.rotor_y, strict=True), 1)
        ),
        "spin": repr(list(vehicle.spin)),
        "hover_speed": repr(hover_speed(vehicle)),
        "differences": "\n".join(f"- {line}" for line in differences(vehicle)),
    }
    return {name: filled("tuner.extensions.rotorpy", Path(name).name, **words) for name in MODULES}


def _import_of(module: str) -> str:
    """Return the statement that imports a module of the copied package."""
    folder, _, name = module.rpartition(".")
    return f"from .{folder} import {name}"


TARGET = ExportTarget(name="rotorpy", title="RotorPy, a controller object with its vehicle (Python)", export=export)
