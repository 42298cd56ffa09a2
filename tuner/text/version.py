"""Versions of installed packages."""

from functools import cache


@cache
def version(package: str = "gainproof") -> str:
    """Return a package's version from its metadata; their import takes 20 ms, and an export asks a dozen times."""
    from importlib import metadata

    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"
