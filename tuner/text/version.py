"""The version of the installed package."""


def version() -> str:
    """Return the version from the metadata of the installation; they take 20 ms to import and are read when asked for."""
    from importlib.metadata import PackageNotFoundError
    from importlib.metadata import version as installed

    try:
        return installed("holdfast")
    except PackageNotFoundError:
        return "not installed"
