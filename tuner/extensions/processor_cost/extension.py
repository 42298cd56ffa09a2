"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.processor_cost"
EXTENSION = Extension(
    name="processor_cost",
    about="Instructions, code and memory of a control step on a Cortex-M4F, counted in an emulator.",
    command_module=f"{HOME}.command",
    commands=("cost",),
    api={"cost": f"{HOME}.api:cost"},
    requirements={"cost": f"{HOME}.requirement:KIND"},
    costs={"cortex_m4f": f"{HOME}.cost:COSTS"},
    printers={"Cost": f"{HOME}.printer:print_costs"},
)
