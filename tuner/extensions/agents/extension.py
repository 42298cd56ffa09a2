"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.agents"
EXTENSION = Extension(
    name="agents",
    about="Commands for agents, over the Model Context Protocol.",
    command_module=f"{HOME}.command",
    commands=("mcp",),
)
