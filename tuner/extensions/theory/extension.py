"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.theory"
EXTENSION = Extension(
    name="theory",
    about="Theorems on gains: guarantees for every axis, and requirements of a study.",
    command_module=f"{HOME}.command",
    commands=("theory",),
    api={"theory": f"{HOME}.api:theory"},
    printers={"Theory": f"{HOME}.printer:print_theory"},
    listings={"theorems": f"{HOME}.listing:theorems"},
    requirements={"guarantee": f"{HOME}.guarantees:KIND"},
)
