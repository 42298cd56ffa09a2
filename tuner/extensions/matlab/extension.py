"""The record of the extension."""

from tuner.extension import Extension

EXTENSION = Extension(
    name="matlab",
    about="Gains as a struct for MATLAB and Octave.",
    targets={"matlab": "tuner.extensions.matlab.export:TARGET"},
)
