"""Outputs of the page in one folder: gains.json, exports, studies and opinions, with the refusals of their commands."""

import os
import re
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import tuner
from plant.errors import InputError, ToolError, shortened
from plant.output_files import write_new_file
from tuner.api.comparing import compare
from tuner.api.exporting import export
from tuner.api.gains import Gains, PlantGains
from tuner.exchange.registry import exporters
from tuner.extension import added
from tuner.extensions.studio.answering import Bench
from tuner.extensions.studio.messages import PageRequest, text_of
from tuner.extensions.studio.session import Setting
from tuner.store.document import taken
from tuner.study.kinds import load_gains_study
from tuner.study.layers import merged_layers, read_layers
from tuner.text.numbers import estimate
from tuner.text.toml_text import toml_text, with_paths
from tuner.text.units import after_number

NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,59}")
"""Name of a file or folder to write: letters, digits and _.- alone."""
COMPARED_FLIGHTS = 256
"""Flights of each scenario of a comparison."""
EXPORT_FLIGHTS = 16
"""Flights before and after rounding of an export from the page."""
Answer = dict[str, Any]


class Outputs:
    """Files of settings in a folder; present: parameter file of what the vehicle flies at present, None without one."""

    def __init__(self, bench: Bench, folder: Path, present: Path | None = None) -> None:
        self._bench, self._folder, self._present = bench, folder, present

    @property
    def offers(self) -> Answer:
        """Offers of the page: targets, folder, and whether gains can be judged."""
        is_plant = isinstance(self._gains(self._bench.session.default), PlantGains)
        targets = [name for name, target in exporters().items() if not is_plant or target.export_plant is not None]
        return {
            "targets": targets,
            "judges": self._present is not None and "judge" in added("api"),
            "folder": str(self._folder),
        }

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

    def save(self, request: PageRequest, message: Answer) -> Answer:
        """Write gains.json."""
        path = self._gains(request.settings[0]).write(self.place(message.get("file"), "file", ".json"))
        return {"text": f"Written: {path}"}

    def export(self, request: PageRequest, message: Answer) -> Answer:
        """Export the gains, as `tuner export` does."""
        target = text_of(message.get("target"), "target")
        place = self.place(message.get("folder"), "folder")
        gains = self._gains(request.settings[0])
        study = self._bench.session.study if isinstance(gains, PlantGains) else None
        made = export(gains, target, place, previous=self._present, study=study, flights=EXPORT_FLIGHTS)
        broken = "rounding violates a limit; do not fly it, see export.json"
        verdict = "rounding breaks no limit" if made.passed else broken
        return {"text": f"Written: {made.folder}; {verdict}.", "lines": list(made.document.lossy)}

    def study(self, request: PageRequest, message: Answer) -> Answer:
        """Write a study whose default is the setting."""
        path = self.place(message.get("file"), "file", ".toml")
        write_study(self._bench, request.settings[0], path)
        return {"text": f"Written: {path}. Run it with: tuner run {path}"}

    def judge(self, request: PageRequest, message: Answer) -> Answer:
        """Judge the gains against the present file, as `tuner judge` does."""
        if self._present is None or "judge" not in added("api"):
            raise InputError("needs the file of the present gains; start tuner studio with --present FILE")
        place = self.place(message.get("folder"), "folder")
        with self._gains(request.settings[0]).file() as file:
            opinion = tuner.judge(file, self._present, out=place)
        document = opinion.document
        return {"text": f"{document.verdict}: {document.sentence} Written: {place}", "lines": list(document.reasons)}

    def compare(self, request: PageRequest, _: Answer) -> Answer:
        """Compare all settings on new flights, as `tuner compare` does."""
        settings = request.settings[1:] + request.settings[:1]
        with TemporaryDirectory() as folder:
            files = [
                self._gains(each).write(Path(folder) / f"{name}.json")
                for each, name in zip(settings, file_names(settings), strict=True)
            ]
            document = compare(files, study=self._bench.session.study, flights=COMPARED_FLIGHTS).document
        last = document.contenders[-1].name
        units = {row.label: row.unit for row in document.quantities}
        lines = [
            f"{row.quantity}: {last} − {row.first} = {' '.join(estimate(*row.estimate, signed=True))}"
            f"{after_number(units[row.quantity])}: {row.verdict if row.lower is None else f'lower with {row.lower}'}"
            for row in document.differences
            if row.second == last
        ]
        return {"text": f"{COMPARED_FLIGHTS} new flights of each scenario, paired:", "lines": lines}

    def _gains(self, setting: Setting) -> Gains:
        return self._bench.session.gains(setting.row)


def file_names(settings: Sequence[Setting]) -> list[str]:
    """Return a name of a file for each setting, all different."""
    plain = [re.sub(r"[^A-Za-z0-9]+", "-", setting.name).strip("-")[:30] or setting.key for setting in settings]
    return [
        name if plain.count(name) == 1 else f"{name}-{setting.key}"
        for name, setting in zip(plain, settings, strict=True)
    ]


def write_study(bench: Bench, setting: Setting, path: Path) -> None:
    """Write a study like the opened one whose default is a setting; a file that cannot be read again is removed."""
    if path.exists():
        raise taken(path)
    session = bench.session
    content = merged_layers(read_layers(session.study.path))
    given = content.get("gains")
    gains = dict(given) if isinstance(given, dict) else {}
    for name, value in session.values(setting.row).items():
        before = gains.get(name)
        gains[name] = {**(before if isinstance(before, dict) else {}), "default": value}
    content["gains"] = gains
    home = session.study.path.resolve().parent
    moved = with_paths(content, lambda name: Path(os.path.relpath(home / name, path.parent)).as_posix())
    write_new_file(path, toml_text(moved).encode())
    try:
        load_gains_study(path, "tuner studio")
    except ToolError:
        path.unlink()
        raise
