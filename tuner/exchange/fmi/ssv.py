"""Gains as an SSV file (System Structure and Parameterization 1.0, Modelica Association, 2019): values with units.

SSP defines a unit by whole exponents of SI base units; the one of a super-twisting gain has fractions, so that gain stands
without a unit and its description names it.
"""

from tuner.exchange.exporter import Request
from tuner.exchange.fmi.description import units_of
from tuner.exchange.fmi.units import base_unit
from tuner.exchange.fmi.variables import gain_variables
from tuner.exchange.fmi.xml import document, element
from tuner.exchange.heading import heading

SPACES = {
    "xmlns:ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "xmlns:ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
}


def parameter_values(request: Request) -> bytes:
    """Return the SSV file of the gains; names are those of the FMU's constants."""
    gains = gain_variables(request.controller)
    parameters = []
    for gain in gains:
        unit = {} if base_unit(gain.unit) is None else {"unit": gain.unit}
        about = {"name": gain.name, "description": f"{gain.about} [{gain.unit}]"}
        parameters.append(element("ssv:Parameter", about, [element("ssv:Real", {"value": gain.start} | unit)]))
    known = [(unit, base) for unit in units_of(gains) if (base := base_unit(unit)) is not None]
    units = [element("ssc:Unit", {"name": unit}, [element("ssc:BaseUnit", base)]) for unit, base in known]
    return document(
        element(
            "ssv:ParameterSet",
            SPACES | {"version": "1.0", "name": "gains", "description": " ".join(f"{line}." for line in heading(request, str)),
                      "generationTool": "holdfast"},
            [element("ssv:Parameters", {}, parameters), element("ssv:Units", {}, units)],
        )
    )  # fmt: skip
