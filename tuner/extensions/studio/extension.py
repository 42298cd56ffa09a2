"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.studio"
EXTENSION = Extension(
    name="studio",
    about="A local page on which gains are moved by hand, and responses, margins and limits follow.",
    command_module=f"{HOME}.command",
    commands=("studio",),
    companions={"live": f"{HOME}.live:live_page"},
)
