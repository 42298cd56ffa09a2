"""The person's side: command line, study files, search, results folders, report."""


def __getattr__(name: str) -> str:
    """Return __version__ of the installed package, read when it is first asked for: the metadata take 20 ms to import."""
    if name != "__version__":
        raise AttributeError(f"module 'tuner' has no attribute '{name}'")
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("holdfast")
    except PackageNotFoundError:
        return "not installed"
