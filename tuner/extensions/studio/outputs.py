"""What leaves the page, written into one folder: gains.json, exports, studies and opinions, with the refusals of their commands."""

import re
from pathlib import Path
from typing import Any

from plant.errors import InputError, shortened
from tuner.extensions.studio.answering import Bench
from tuner.extensions.studio.asking import Asked, text_of

NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,59}")
"""Name of a file or folder to write: letters, digits and _.- alone."""
Answer = dict[str, Any]


class Outputs:
    """Files of settings.

    Args:
        bench: The opened study.
        folder: Folder that takes all files.
    """

    def __init__(self, bench: Bench, folder: Path) -> None:
        self._bench, self._folder = bench, folder

    def place(self, given: Any, key: str, ending: str = "") -> Path:
        """Return the place of a file by its name; InputError for a name with folders in it or another ending."""
        name = text_of(given, key, 60)
        if not NAME.fullmatch(name) or not name.endswith(ending):
            raise InputError(
                f"given '{shortened(name)}'; allowed: a name of letters, digits, _, . and - without folders"
                f"{f', that ends in {ending}' if ending else ''}; it is written into {self._folder}",
                key=key,
            )
        return self._folder / name

    def save(self, asked: Asked, message: dict[str, Any]) -> Answer:
        """Write gains.json."""
        path = self._bench.session.gains(asked.settings[0].row).write(self.place(message.get("file"), "file", ".json"))
        return {"text": f"Written: {path}"}
