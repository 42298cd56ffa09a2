"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.notebook"
EXTENSION = Extension(
    name="notebook",
    about="Progress of long calls below the cell of a notebook, and the studio in it.",
    requires=("studio",),
    api={"studio": f"{HOME}.studio:studio"},
    watchers={"notebook": f"{HOME}.watcher:notebook_watcher"},
)
