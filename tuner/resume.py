"""Go on with a run where it stopped, by replay: the search is asked again and the flights that are there are told to it.

The result is that of a run that was never interrupted, to the bit: nothing of the search's inner state is stored that could be
stale, and a file that was damaged is flown again. For runs that were stopped, killed, ran out of disk, or shall search longer.
"""

from dataclasses import replace
from pathlib import Path

from plant.errors import InputError, StoreError
from tuner.store.folder import Folder
from tuner.store.inputs import TUNING, RunRecord, check_unchanged, read_record, write_record
from tuner.study import load_study
from tuner.study.study import Study


def recorded_study(path: Path) -> tuple[Study, RunRecord]:
    """Return the study of a tuning run's folder as it was run; StoreError where it cannot be had again."""
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
    return study, record


def reopen(path: Path, budget: int | None) -> tuple[Study, Folder]:
    """Return the study of a results folder, with another number of generations if asked for, and the folder for writing."""
    study, record = recorded_study(path)
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
    return longer, folder
