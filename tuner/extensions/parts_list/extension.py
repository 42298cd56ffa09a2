"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.parts_list"
EXTENSION = Extension(
    name="parts_list",
    about="An airframe estimated from its parts list, with 95 % ranges.",
    api={"estimate_airframe": f"{HOME}.api:estimate_airframe"},
    documents={"airframe-estimate": f"{HOME}.document:EstimateDocument"},
    printers={"EstimatedAirframe": f"{HOME}.printer:print_estimate"},
)
