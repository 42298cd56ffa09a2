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
from pathlib import Path

from plant import laws
from plant.gains import gain_addresses
from plant.nominal import ControlOptions
from plant.vehicle import Vehicle
from tuner.exchange.aboard import rollback_request
from tuner.exchange.rotorpy import controller as rotorpy_controller
from tuner.exchange.rotorpy.vehicle import differences, parameter_text
from tuner.exchange.target import Bundle, Request, Target
from tuner.exchange.texts import heading, markdown, python_docstring, tool

PACKAGE = "holdfast_rotorpy"
VERSION = "RotorPy 3.0"
# What stands in the packages inside, whose own would import every law.
PART = '"""Copies of holdfast\'s model functions, those that this controller calls."""\n'
CONTROLLER = Path(rotorpy_controller.__file__)
_OF_PLANT = re.compile(r"^from plant(\.[\w.]+)? import", re.MULTILINE)


def export(request: Request) -> Bundle:
    """Write the package; every law can be carried, see `Target.export`."""
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
    """Return name -> content of the files of the package and of its README."""
    cascade = request.controller.cascade
    files = {
        "README.md": readme(request, sentence),
        f"{PACKAGE}/__init__.py": _init(request),
        f"{PACKAGE}/gains.py": _gains(request, sentence),
        f"{PACKAGE}/vehicle_params.py": vehicle_parameters(request),
        f"{PACKAGE}/flight_controller.py": relative(CONTROLLER.read_text(encoding="utf-8"), ".plant"),
    }
    files |= {
        f"{PACKAGE}/{name}": text for name, text in copies({cascade.position.name, cascade.attitude.name}).items()
    }
    return {name: text.encode() for name, text in sorted(files.items())}


def copies(names: set[str]) -> dict[str, str]:
    """Return path -> text of the modules of plant that the controller reaches with these laws, and of their packages."""
    reached = reach(CONTROLLER, {f"plant.laws.{module_of(name)}" for name in names})
    texts = {}
    for module in sorted(reached):
        *folders, name = module.split(".")
        dots = "." * len(folders)
        texts[f"{'/'.join(folders)}/{name}.py"] = relative(source(module).read_text(encoding="utf-8"), dots)
        texts[f"{'/'.join(folders)}/__init__.py"] = PART
    return texts


def module_of(law: str) -> str:
    """Return the module of plant.laws that defines a law."""
    names = [name for name, module in vars(laws).items() if getattr(module, "LAW", None) is laws.LAWS[law]]
    assert len(names) == 1, (law, names)
    return names[0]


def reach(file: Path, start: set[str]) -> set[str]:
    """Return the modules of plant that a file and the given modules import, directly or through others."""
    waiting, found = imports(file) | start, set()
    while waiting:
        module = waiting.pop()
        found.add(module)
        waiting |= imports(source(module)) - found
    return found


def imports(file: Path) -> set[str]:
    """Return the modules of plant that a file imports."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == "plant":
            within = [f"{node.module}.{name.name}" for name in node.names]
            found |= {name if _is_module(name) else node.module for name in within}
    return found


def _is_module(name: str) -> bool:
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:
        return False


def source(module: str) -> Path:
    """Return the file of a module."""
    spec = importlib.util.find_spec(module)
    assert spec is not None and spec.origin is not None, module
    return Path(spec.origin)


def relative(text: str, root: str) -> str:
    """Return the text of a module with its imports from plant made relative to `root`, which stands for plant."""
    return _OF_PLANT.sub(lambda found: f"from {_joined(root, found.group(1) or '')} import", text)


def _joined(root: str, rest: str) -> str:
    return root + rest.lstrip(".") if root.endswith(".") else root + rest


def _init(request: Request) -> str:
    return "\n".join(
        [
            f'"""{heading(request, python_docstring)[2]}; gains from {tool()}, flown in RotorPy: see `controller`."""',
            "",
            "from .flight_controller import FlightController",
            "from .gains import controller",
            "from .vehicle_params import initial_state, quad_params",
            "",
            '__all__ = ["FlightController", "controller", "initial_state", "quad_params"]',
            "",
        ]
    )


def _gains(request: Request, sentence: str) -> str:
    """Return the module with the numbers: gains by address, vehicle, options; repr gives every double back as it was."""
    controller = request.controller
    position, attitude = module_of(controller.cascade.position.name), module_of(controller.cascade.attitude.name)
    modules = [f"from .plant.laws import {name}" for name in sorted({position, attitude})]
    rows = [
        f'    "{gain.address}": {controller.gains[gain.column]!r},  # {gain.unit}'
        for gain in gain_addresses(controller.cascade)
    ]
    return "\n".join(
        [
            '"""The gains and the vehicle they were tuned for.',
            "",
            *[f"{line}." for line in heading(request, python_docstring)],
            *([python_docstring(sentence)] if sentence else []),
            '"""',
            "",
            "from .flight_controller import FlightController",
            *modules,
            "from .plant.nominal import ControlOptions",
            "from .plant.vectors import Rotors, Vec3",
            "from .plant.vehicle import Vehicle",
            "",
            "GAINS = {",
            *rows,
            "}",
            f"VEHICLE = {controller.airframe.vehicle!r}",
            f"OPTIONS = {_options(controller.options)}",
            f"CONTROL_PERIOD = {controller.control_period!r}  # s",
            "",
            "",
            "def controller() -> FlightController:",
            '    """Return a controller at rest."""',
            f"    laws = {position}.LAW, {attitude}.LAW",
            "    return FlightController(*laws, list(GAINS.values()), VEHICLE, OPTIONS, CONTROL_PERIOD)",
            "",
        ]
    )


def _options(options: ControlOptions) -> str:
    return f"ControlOptions({', '.join(f'{name}={value!r}' for name, value in asdict(options).items())})"


def vehicle_parameters(request: Request) -> str:
    """Return the module with RotorPy's dictionary of the vehicle and its state at rest."""
    vehicle: Vehicle = request.controller.airframe.vehicle
    lines = [
        '"""The airframe in RotorPy\'s terms; see README.md for what differs.',
        "",
        *heading(request, python_docstring),
        '"""',
        "",
    ]
    return "\n".join([*lines, parameter_text(vehicle)])


def readme(request: Request, sentence: str) -> str:
    """Return how to run it, and what differs."""
    rate = 1.0 / request.controller.control_period
    return "\n".join(
        [
            "# Gains in RotorPy",
            "",
            *[f"{line}.  " for line in heading(request, markdown)],
            *([markdown(sentence)] if sentence else []),
            "",
            f"Copy `{PACKAGE}/` beside your script (`pip install rotorpy`; nothing else is needed) and run:",
            "",
            "```python",
            "import numpy as np",
            "from rotorpy.environments import Environment",
            "from rotorpy.trajectories.hover_traj import HoverTraj",
            "from rotorpy.vehicles.multirotor import Multirotor",
            f"from {PACKAGE} import controller, initial_state, quad_params",
            "",
            'vehicle = Multirotor(quad_params, initial_state(), control_abstraction="cmd_ctbm")',
            "target = HoverTraj(x0=np.array([1.0, 0.0, 0.0]))",
            f"flight = Environment(vehicle, controller(), target, sim_rate={rate:g})",
            'print(flight.run(t_final=8)["state"]["x"][-1])',
            "```",
            "",
            f"`sim_rate` must be a whole multiple of {rate:g} Hz. ",
            "`plant/` holds copies of holdfast's model functions (BSD-3-Clause).",
            "",
            "What differs from holdfast's own simulation:",
            "",
            *[f"- {line}" for line in differences(request.controller.airframe.vehicle)],
            "",
        ]
    )


TARGET = Target(name="rotorpy", title="RotorPy, a controller object with its vehicle (Python)", export=export)
