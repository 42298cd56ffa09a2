"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.identification"
EXTENSION = Extension(
    name="identification",
    about="An airframe with 95 % intervals out of flight logs.",
    requires=(
        "logs",
        "vehicle_fit",
    ),
    command_module=f"{HOME}.command",
    commands=("identify",),
    api={"check_logs": f"{HOME}.api:check_logs", "identify": f"{HOME}.api:identify"},
    documents={
        "identification": f"{HOME}.document:IdentificationDocument",
        "log-check": f"{HOME}.document:LogCheckDocument",
    },
    printers={"Identification": f"{HOME}.printer:print_identification", "LogCheck": f"{HOME}.printer:print_log_check"},
    figures={"identification": f"{HOME}.charts:figures_of"},
)
