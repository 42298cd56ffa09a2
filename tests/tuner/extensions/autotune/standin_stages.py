"""Stages of an autotune that take no time: they write all that they read, so a stage of other inputs has other bytes."""

import shutil
from pathlib import Path
from typing import Any, NamedTuple

import tuner
from plant.quadrotor.airframes import load
from tuner.extensions.autotune import api as autotuning
from tuner.extensions.autotune import stages as stages
from tuner.extensions.autotune.stage import Stage

FLIGHT: Any = {"airframe": "crazyflie-pybullet", "mapping": "columns.toml"}


class Standin(Stage):
    """A stage that writes its name and all that it reads, in no time; its inputs are those of the real one."""

    made: list[str]
    ends: str | None

    def make(self) -> Any:
        self.made.append(self.name)
        for output in reversed(self.outputs):
            self.write(output)
        return "too little" if self.name == self.ends else None

    def write(self, output):
        file = self.out / output
        read = " and ".join(f"{name} {digest_of(value)}" for name, value in self.inputs().items())
        file.parent.mkdir(exist_ok=True)
        file.write_text(f"{self.name}: {read}\n")

    def sentence(self):
        return f"{self.name} made"


def digest_of(value):
    return value.get("sha256", value)


class StandinIdentification(Standin, stages.IdentificationStage):
    def write(self, output):
        shutil.copy(load("crazyflie-pybullet").path, self.out / output) if output == "vehicle.toml" else super().write(
            output
        )


class StandinImport(Standin, stages.ImportStage):
    def make(self):
        stages.ImportStage.make(self)
        self.made.append(self.name)


class StandinStudy(Standin, stages.StudyStage):
    def make(self):
        stages.StudyStage.make(self)
        self.made.append(self.name)


class StandinSearch(Standin, stages.SearchStage):
    """One whose run tells the study that it began with, however often it is gone on with."""

    def make(self):
        self.made.append(self.name)
        run = self.out / "run"
        run.mkdir(exist_ok=True)
        if not (run / "run.json").exists():
            (run / "run.json").write_text((self.out / "study.toml").read_text())
        if KILLED in self.made:
            self.made.remove(KILLED)
            raise KeyboardInterrupt
        for name in ("gains.json", "front.csv"):
            (run / name).write_text((run / "run.json").read_text())
        return "too little" if self.name == self.ends else None


class StandinExport(Standin, stages.ExportStage):
    outputs = ("export",)

    def write(self, output):
        (self.out / "export").mkdir()
        for name in ("export.json", "parameters"):
            super().write(f"export/{name}")


class StandinOpinion(Standin, stages.OpinionStage):
    @property
    def _exported(self):
        return self.out / "export" / "parameters"


class StandinConfirmation(Standin, stages.ConfirmationStage):
    pass


class StandinFirstFlights(Standin, stages.FirstFlightsStage):
    pass


STANDINS = (
    StandinIdentification,
    StandinImport,
    StandinStudy,
    StandinSearch,
    StandinExport,
    StandinOpinion,
    StandinConfirmation,
    StandinFirstFlights,
)
NAMES = [stage.name for stage in STANDINS if stage is not StandinConfirmation]
KILLED = "killed"


class JsonPage(NamedTuple):
    document: Any

    def text(self):
        return self.document.text()


def tuned(**changes):
    given = {"logs": "log.csv", "vehicle": "present.yaml", "out": "out", **FLIGHT, **changes}
    return tuner.autotune(given.pop("logs"), given.pop("vehicle"), given.pop("out"), **given)


def contents(folder="out"):
    """Content of every file, but for the times that a call took and what no process needs again."""
    files = {file.relative_to(folder).as_posix(): file for file in Path(folder).rglob("*") if file.is_file()}
    return {
        name: file.read_bytes()
        for name, file in files.items()
        if file.name not in (".lock", "autotune.json", "index.html", "manifest.json")
    }


def replace_stages(monkeypatch):
    """Replace the stages by quick ones; the list of those that are made."""
    made = []
    monkeypatch.setattr(autotuning, "STAGES", STANDINS)
    monkeypatch.setattr(Standin, "made", made, raising=False)
    monkeypatch.setattr(Standin, "ends", None, raising=False)
    monkeypatch.setattr(autotuning, "_choice", lambda out: [])
    monkeypatch.setattr(autotuning, "autotune_page", lambda document, *_: JsonPage(document))
    monkeypatch.setattr(stages, "program_digest", lambda firmware, binary: Path(binary).read_text())
    return made
