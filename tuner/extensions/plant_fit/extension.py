"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.plant_fit"
EXTENSION = Extension(
    name="plant_fit",
    about="A plant with 95 % intervals, and a study of it, out of a table of measured inputs and outputs.",
    requires=("logs",),
    command_module=f"{HOME}.command",
    commands=("fit",),
    api={"fit": f"{HOME}.api:fit"},
    documents={"plant-fit": f"{HOME}.document:PlantFitDocument"},
    printers={"PlantFit": f"{HOME}.printer:print_plant_fit"},
    figures={"plant_fit": f"{HOME}.charts:figures_of"},
)
