"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.px4"
EXTENSION = Extension(
    name="px4",
    about="PX4: parameter files both ways, its control libraries as a judge.",
    requires=("autopilots", "logs"),
    targets={"px4": f"{HOME}.export:TARGET"},
    sources={"px4": f"{HOME}.source:SOURCE"},
    firmwares={"px4": f"{HOME}.bench:PX4_FIRMWARE"},
)
