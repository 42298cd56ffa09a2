"""The record of the extension."""

from tuner.extension import Extension

HOME = "tuner.extensions.scaffold"
EXTENSION = Extension(
    name="scaffold",
    about="The files of a new extension: a package outside of the tool, to be filled in.",
    templates={"extension": f"{HOME}.writing:write_extension"},
)
