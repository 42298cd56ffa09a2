"""The record of the extension."""

from tuner.extension import Extension

EXTENSION = Extension(
    name="rotorpy",
    about="The controller as an object of RotorPy.",
    targets={"rotorpy": "tuner.extensions.rotorpy.export:TARGET"},
)
