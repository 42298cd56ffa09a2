"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.phase_plane"
EXTENSION = Extension(
    name="phase_plane",
    about="Phase planes of flights: the error of each loop against its rate, under any law.",
    command_module=f"{HOME}.command",
    commands=("phase-plane",),
    api={"phase_plane": f"{HOME}.api:phase_plane"},
)
