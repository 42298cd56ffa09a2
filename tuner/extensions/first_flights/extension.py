"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.first_flights"
EXTENSION = Extension(
    name="first_flights",
    about="Before the first flight: firmware in the loop, and steps from present to tuned gains.",
    requires=("autopilots",),
    command_module=f"{HOME}.command",
    commands=(
        "approach",
        "confirm",
    ),
    api={"approach": f"{HOME}.approach_api:approach", "confirm": f"{HOME}.confirmation_api:confirm"},
    documents={
        "approach": f"{HOME}.approach_document:ApproachDocument",
        "confirmation": f"{HOME}.confirmation_document:ConfirmationDocument",
    },
    printers={
        "Approach": f"{HOME}.approach_printer:print_approach",
        "Confirmation": f"{HOME}.confirmation_printer:print_confirmation",
    },
)
