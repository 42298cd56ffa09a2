"""The record of the extension."""

from tuner.extension import Extension

EXTENSION = Extension(
    name="fmi",
    about="The controller as a Functional Mock-up Unit for FMI 2.0.",
    targets={"fmi": "tuner.extensions.fmi.export:TARGET"},
)
