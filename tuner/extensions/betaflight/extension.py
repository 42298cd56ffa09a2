"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.betaflight"
EXTENSION = Extension(
    name="betaflight",
    about="Betaflight: command lines both ways, its simulator as a judge.",
    requires=("autopilots",),
    targets={"betaflight": f"{HOME}.export:TARGET"},
    sources={"betaflight": f"{HOME}.source:SOURCE"},
    firmwares={"betaflight": f"{HOME}.bench:BETAFLIGHT"},
)
