"""The record of the extension."""

from tuner.extension import Extension

EXTENSION = Extension(
    name="fmu",
    about="Plants that are FMUs for co-simulation (FMI 2 and 3), flown in processes of their own.",
    plants={"fmu": "tuner.extensions.fmu.source:SOURCE"},
)
