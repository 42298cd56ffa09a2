"""The version of the installed package."""


def version() -> str:
    """Return the version from the metadata of the installation; they take 20 ms to import and are read when asked for."""
    from importlib import metadata

    try:
        return metadata.version("holdfast")
    except metadata.PackageNotFoundError:
        return "not installed"
