"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.betaflight_adrc"
EXTENSION = Extension(
    name="betaflight_adrc",
    about="Betaflight's active disturbance rejection on the rate loop: margins, and the axis that rings.",
    requires=("autopilots", "betaflight", "logs"),
    command_module=f"{HOME}.command",
    commands=("adrc",),
    api={"adrc": f"{HOME}.api:adrc"},
    documents={"adrc": f"{HOME}.document:AdrcDocument"},
    targets={"betaflight_adrc": f"{HOME}.target:TARGET"},
    firmwares={"betaflight_adrc": f"{HOME}.bench:BETAFLIGHT_ADRC"},
    printers={"AdrcForecast": f"{HOME}.printer:print_adrc_forecast"},
)
