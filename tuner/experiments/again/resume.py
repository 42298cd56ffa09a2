"""Go on with a run where it stopped, by replay: the search is asked again and the flights that are there are told to it.

The result is that of a run that was never interrupted, to the bit: nothing of the search's inner state is stored that could be
stale, and a file that was damaged is flown again. For runs that were stopped, killed, ran out of disk, or shall search longer.
"""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from plant.errors import InputError, StoreError
from tuner.store.advice import TUNING
from tuner.store.folder import Folder
from tuner.store.inputs import RunRecord, check_unchanged, compute_as_recorded, read_record, write_record
from tuner.study import load_study
from tuner.study.study import Study


def recorded_study(path: Path, here: bool = False) -> tuple[Study, RunRecord]:
    """Return the study of a tuning run's folder as it was run, and go over to the run's arithmetic, unless `here`.

    Raises StoreError where either cannot be had again.
    """
    record = read_record(path)
    if record.kind != TUNING:
        raise StoreError(
            f"{path} is the folder of a {record.kind}; give that of a tuning run, such as one in its contenders/"
        )
    try:
        study = load_study(path / record.study, {"search.generations": record.generations})
    except InputError as error:
        raise StoreError(f"the inputs of this run are damaged: {error}") from None
    check_unchanged(path, record, study.digest())
    study = study if record.si else study.in_units_of_limits()
    if not here:
        compute_as_recorded(path, record)
    return study, record


def reopen(path: Path, budget: int | None, here: bool = False) -> tuple[Study, Folder]:
    """Return the study of a results folder, with another number of generations if asked for, and the folder for writing.

    here: compute with this machine's arithmetic; what another recorded has other keys, so all of it is computed anew.
    """
    study, record = recorded_study(path, here)
    folder = Folder.open(path)
    if budget is None or budget == record.generations:
        return study, folder
    if record.generations is not None and budget < record.generations:
        raise InputError(
            f"given {budget} generations; the run was asked for {record.generations}, and a search is only ever extended",
            key="--budget",
        )
    longer = load_study(path / record.study, {"search.generations": budget})
    write_record(folder, replace(record, digest=longer.digest(), generations=budget))
    return longer if record.si else longer.in_units_of_limits(), folder


def compute_as_reused(paths: Iterable[Path]) -> None:
    """Go over to the arithmetic of the runs whose flights are to be taken over; StoreError where it is not to be had."""
    for path in paths:
        try:
            record = read_record(path)
        except StoreError:
            # What is left of it is taken over all the same, where its keys are those of this run.
            continue
        compute_as_recorded(path, record, "leave --reuse out")
