"""The record of the extension."""

from tuner.extension import Extension

EXTENSION = Extension(
    name="step_records",
    about="Folders and lines in which a command goes on where it ended: of tails, trials and autotunes.",
)
