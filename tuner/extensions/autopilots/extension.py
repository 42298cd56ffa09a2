"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.autopilots"
EXTENSION = Extension(
    name="autopilots",
    about="Parts that the autopilots share: cascades, parameter files, boards in the loop.",
    requires=("logs",),
    listings={"firmwares": f"{HOME}.registry:list_firmwares"},
)
