"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.ardupilot"
EXTENSION = Extension(
    name="ardupilot",
    about="ArduPilot: parameter files both ways, its control libraries as a judge.",
    requires=("autopilots", "logs"),
    targets={"ardupilot": f"{HOME}.export:TARGET"},
    sources={"ardupilot": f"{HOME}.source:SOURCE"},
    firmwares={"ardupilot": f"{HOME}.bench:ARDUPILOT"},
)
