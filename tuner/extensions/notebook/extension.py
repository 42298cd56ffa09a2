"""The record of the extension."""

from tuner.extension import Extension

EXTENSION = Extension(
    name="notebook",
    about="Progress of long calls below the cell of a notebook.",
    watchers={"notebook": "tuner.extensions.notebook.watcher:notebook_watcher"},
)
