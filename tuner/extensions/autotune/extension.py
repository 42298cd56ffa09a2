"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.autotune"
EXTENSION = Extension(
    name="autotune",
    about="One command from flight logs and a parameter file to first flights.",
    requires=(
        "autopilots",
        "first_flights",
        "flight_plans",
        "identification",
        "judge",
        "logs",
        "step_records",
    ),
    command_module=f"{HOME}.command",
    commands=("autotune",),
    api={"autotune": f"{HOME}.api:autotune"},
    documents={"autotune": f"{HOME}.document:AutotuneDocument"},
    printers={"Autotuned": f"{HOME}.printer:print_autotune"},
)
