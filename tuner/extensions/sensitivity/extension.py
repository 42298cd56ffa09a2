"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.sensitivity"
EXTENSION = Extension(
    name="sensitivity",
    about="Shares of gains and of turbulence in each objective: Sobol indices of flights over the whole search ranges.",
    command_module=f"{HOME}.command",
    commands=("sensitivity",),
    api={"sensitivity": f"{HOME}.api:sensitivity"},
    documents={"sensitivity": f"{HOME}.document:SensitivityDocument"},
    folders=(f"{HOME}.document:SensitivityFolder",),
    printers={"Sensitivity": f"{HOME}.printer:print_sensitivity"},
    figures={"sensitivity": f"{HOME}.figure:figures_of"},
    sections={"sensitivity": f"{HOME}.section:sensitivity_section"},
)
