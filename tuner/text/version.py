"""Versions of installed packages."""

from functools import cache


@cache
def version(package: str = "gainproof") -> str:
    """Return the version of a package from its metadata, whose reader takes 20 ms to import; an export names it a dozen times."""
    from importlib import metadata

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"
