"""The controller of a user's plant as an FMU: set points and measurements in, inputs of the plant out."""

from collections.abc import Callable, Iterator
from dataclasses import replace

from plant.backends.c_code import REALS
from plant.records import flatten, paths, unit_of
from tuner.exchange.aboard import plant_rollback
from tuner.exchange.c99.export import as_held
from tuner.exchange.c99.plant import TunedPlant, channel_lines, plant_program, tuned_plant
from tuner.exchange.c99.sources import write_code
from tuner.exchange.target import PlantBundle, PlantRequest
from tuner.exchange.texts import c_comment, filled, tool, xml_text
from tuner.extensions.fmi.archive import (
    BUILT_IN,
    MOCK_UP,
    PREFIX,
    REAL,
    SINGLE,
    UNITS,
    VALUES,
    VERSION,
    Code,
    built,
    of_binary,
    packed,
)
from tuner.extensions.fmi.code import filled_binding
from tuner.extensions.fmi.variables import GAIN_PREFIX, FmuVariable
from tuner.extensions.fmi.xml_files import ModelText, model_description, parameter_values

ABOUT = {"value": "Set point", "rate": "Rate of the set point", "acceleration": "Acceleration of the set point"}


def export_loops(request: PlantRequest) -> PlantBundle:
    """Return FMU and SSV file of a plant's controller."""
    back, sentence = plant_rollback(request)
    mock_up, values, code = plant_fmu(request)
    former, former_values, _ = plant_fmu(back)
    gains = as_held(request.controller.gains, REALS[request.settings[REAL.name]])
    return PlantBundle(
        {MOCK_UP: mock_up, VALUES: values},
        {MOCK_UP: former, VALUES: former_values, "README.txt": f"{sentence}\n".encode()},
        replace(request.controller, gains=gains),
        _differences(request, code),
        VERSION,
    )


def plant_fmu(request: PlantRequest) -> tuple[bytes, bytes, Code]:
    """Return FMU, SSV file and code of a plant's controller."""
    tuned = tuned_plant(request.controller.study.system, request.controller.gains)
    exposed, gains = plant_variables(tuned), list(_gains(tuned))
    generated = write_code(plant_program(tuned), request.settings[REAL.name], PREFIX, request.digest)

    def bind(guid: str) -> str:
        rest = zip(tuned.system.plant.Input._fields, _inputs_at_rest(tuned), strict=True)
        held = "\n".join(f"    held.{name} = (gainproof_real){value!r};" for name, value in rest)
        lines = _heading(request, tuned, c_comment)
        return filled_binding("plant_binding.h", tuned.period, exposed, lines, guid=guid, held=held)

    code, title = built(generated, request.digest, bind), f"Controller of {tuned.system.plant.title}"
    text = ModelText(title, " ".join(_heading(request, tuned, str)), tuned.period)
    values = parameter_values(gains, text.description)
    page = filled(
        "tuner.extensions.fmi",
        "index.html",
        title=xml_text(title),
        axes="Units are those of the variables.",
        heading="\n".join(f"<p>{line}</p>" for line in _heading(request, tuned, xml_text)),
        guid=code.guid,
    )
    return packed(code, model_description(text, exposed, code.guid, UNITS), values, page), values, code


def _heading(request: PlantRequest, tuned: TunedPlant, write: Callable[[str], str]) -> list[str]:
    channels = "; ".join(" ".join(line.split()) for line in channel_lines(tuned.system.plan))
    return [
        write(f"Written by {tool()} from the gains {request.digest}."),
        write(f"Plant: {tuned.system.plant.name}. Channels: {channels}. Control period {tuned.period:.10g} s."),
    ]


def plant_variables(tuned: TunedPlant) -> list[FmuVariable]:
    """Return all variables in the order of their value references; inputs and outputs start where the plant rests."""
    plant = tuned.system.plant
    shown = dict(zip(plant.Output._fields, flatten(plant.at_rest(tuned.system.parameters)[2]), strict=True))
    rest = {each.name: shown[each.output] for each in tuned.system.plan.outer}
    exposed = []
    for path in paths(tuned.Reference):
        channel, part = path.split(".")
        unit, start = _unit(tuned.Reference.__annotations__[channel].__annotations__[part]), rest[channel]
        about = f"{ABOUT[part]} of {channel}"
        exposed.append(
            FmuVariable(f"reference.{path}", "input", unit, start * (part == "value"), about, f"reference.{path}")
        )
    for name, kind in tuned.Measured.__annotations__.items():
        member = f"measured.{name}"
        exposed.append(FmuVariable(member, "input", _unit(kind), shown[name], f"Measured {name}", member))
    for (name, kind), held in zip(plant.Input.__annotations__.items(), _inputs_at_rest(tuned), strict=True):
        exposed.append(FmuVariable(f"command.{name}", "output", _unit(kind), held, f"Command to {name}", name))
    period = FmuVariable("control_period", "constant", "s", tuned.period, "Time between two control steps")
    return [*exposed, period, *_gains(tuned)]


def _inputs_at_rest(tuned: TunedPlant) -> list[float]:
    return [float(value) for value in flatten(tuned.system.plant.at_rest(tuned.system.parameters)[1])]


def _gains(tuned: TunedPlant) -> Iterator[FmuVariable]:
    for gain, value in zip(tuned.system.gains, tuned.gains, strict=True):
        yield FmuVariable(f"{GAIN_PREFIX}{gain.address}", "constant", gain.unit, value, gain.info.meaning)


def _unit(kind: object) -> str:
    return unit_of(kind) or "1"


def _differences(request: PlantRequest, code: Code) -> tuple[str, ...]:
    system = request.controller.study.system
    prompt = [each.name for each in system.plan.actuators if not each.delay]
    late = (
        f"A co-simulation hands commands on one control period of {system.timing.control_period:g} s after their measurement; "
        + (
            f"the gains were tuned without a delay of {', '.join(prompt)}: tune with that delay of the actuator."
            if prompt
            else "that period is a part of the actuators' delay: give the plant's model the rest."
        )
    )
    single = () if request.settings[REAL.name] == "double" else (SINGLE,)
    return (BUILT_IN, late, *single, of_binary(code))
