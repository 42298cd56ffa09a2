"""Files that the product opens, noted for a test."""

from pathlib import Path


def opened_files(monkeypatch):
    """Absolute paths of all files that are opened from here on, in their order."""
    paths, opened = [], open

    def open_and_note(file, *arguments, **options):
        if not isinstance(file, int):
            paths.append(Path(file).absolute())
        return opened(file, *arguments, **options)

    monkeypatch.setattr("builtins.open", open_and_note)
    return paths
