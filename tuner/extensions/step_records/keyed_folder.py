"""Folders in which a command goes on where it ended: of a tail and of an autotune.

Such a folder holds the outputs of steps. `stages.json` records each step's inputs when the step begins, and its end. The key of a
step is the digest of its inputs and of the key of the step before it, so a step is taken from the record only where all that it
and its forerunners read is as it was.
"""

from collections.abc import Iterable
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Literal

from plant.errors import StoreError, shortened
from plant.output_files import ASIDE
from tuner.extensions.step_records.key_inputs import Inputs, changes, step_key
from tuner.store.advice import STEPS
from tuner.store.document import Document, DocumentPart, OneOf
from tuner.store.folder import Folder
from tuner.store.lock import NAME as LOCK
from tuner.store.manifest import FILE as MANIFEST

FORMAT, VERSION = "gainproof-stages", "0.1"


class StepState(StrEnum):
    """State of a step on record.

    Attributes:
        NEW: without a record of these inputs; outputs of an earlier try are to be removed.
        BEGUN: a process began it with the same inputs and did not end it.
        STOPPED: it ended without an output that a next step could read, from the same inputs.
        DONE: it is done, from the same inputs.
    """

    NEW = "new"
    BEGUN = "begun"
    STOPPED = "stopped"
    DONE = "done"


class StepRecord(DocumentPart):
    """A step that was begun.

    Args:
        name: Name of the step.
        key: Digest of its inputs and of the key before it.
        inputs: Inputs by name.
        state: State when the record was written.
    """

    name: str
    key: str
    inputs: dict[str, dict[str, str]]
    state: Annotated[str, OneOf((StepState.BEGUN, StepState.STOPPED, StepState.DONE))]


class StepsDocument(Document):
    """Content of stages.json.

    Args:
        kind: Kind of the folder, "tail" or "autotune".
        steps: Steps in the order in which they were begun.
    """

    format: Literal["gainproof-stages"]
    version: Literal["0.1"]
    kind: str
    steps: list[StepRecord]


class KeyedFolder:
    """A folder of steps, which this process alone writes.

    Args:
        kind: Kind of the folder, as a message calls it.
        folder: The folder, locked.
        steps: Records of its steps.
    """

    def __init__(self, kind: str, folder: Folder, steps: Iterable[StepRecord] = ()) -> None:
        self.folder, self._kind = folder, kind
        self._steps = {step.name: step for step in steps}

    @classmethod
    def begin(cls, path: Path, kind: str) -> "KeyedFolder":
        """Make a folder, or go on with one of its kind; StoreError where it holds something else or is damaged."""
        if not (path / STEPS).exists():
            return cls(kind, Folder.open(path) if _is_unbegun(path) else Folder.create(path, inside="", empty=True))
        folder = Folder.open(path)
        try:
            document = StepsDocument.read(path / STEPS)
            if document.kind != kind:
                article = "an" if document.kind[:1] in "aeiou" else "a"
                raise StoreError(
                    f"{path} holds {article} {shortened(document.kind)} and no {kind}; choose another folder with --out"
                )
        except StoreError:
            folder.close()
            raise
        return cls(kind, folder, document.steps)

    def __enter__(self) -> "KeyedFolder":
        self.folder.__enter__()
        return self

    def __exit__(self, *ending: object) -> None:
        self.folder.__exit__(*ending)  # type: ignore[arg-type]

    def state(self, name: str, inputs: Inputs, before: str, restart: str | None = None) -> StepState:
        """Return the state of a step; StoreError names the input that changed after the step had read it.

        Args:
            name: Name of the step.
            inputs: Its inputs now.
            before: Key of the step before it, "" for the first.
            restart: Option that begins the step again, None where there is none.
        """
        step = self._steps.get(name)
        if step is None:
            return StepState.NEW
        if step.key == step_key(inputs, before):
            return StepState(step.state)
        if step.state == StepState.STOPPED:
            return StepState.NEW
        changed = "; ".join(changes(step.inputs, inputs)) or "a stage before it was made again"
        remedy = "give the former command again" if restart is None else f"make it again with {restart}"
        raise StoreError(
            f"{self.folder.path}: {changed} after the {name} was begun; choose another folder with --out, or {remedy}"
        )

    def start(self, name: str, inputs: Inputs, before: str) -> None:
        """Record that a step is begun."""
        given = {key: dict(value) for key, value in inputs.items()}
        self._record(StepRecord(name=name, key=step_key(inputs, before), inputs=given, state=StepState.BEGUN))

    def end(self, name: str, state: StepState) -> None:
        """Record the end of a step."""
        self._record(self._steps[name].model_copy(update={"state": state.value}))

    def forget(self, names: Iterable[str]) -> None:
        """Take steps off the record."""
        for name in names:
            self._steps.pop(name, None)
        self._write()

    def _record(self, step: StepRecord) -> None:
        self._steps[step.name] = step
        self._write()

    def _write(self) -> None:
        steps = list(self._steps.values())
        self.folder.write_json(STEPS, StepsDocument(format=FORMAT, version=VERSION, kind=self._kind, steps=steps))


def _is_unbegun(path: Path) -> bool:
    """True for a folder without anything but its lock and manifest."""
    names = [file.name for file in path.iterdir()] if path.is_dir() and not path.is_symlink() else []
    return bool(names) and all(name in (LOCK, MANIFEST) or name.endswith(ASIDE) for name in names)
