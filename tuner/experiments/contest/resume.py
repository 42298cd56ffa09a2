"""Go on with a contest: contenders whose search is finished are replayed, the others go on, and all are compared."""

from pathlib import Path

from plant.errors import InputError, StoreError
from tuner.store.folder import Folder
from tuner.store.inputs import check_unchanged, compute_as_recorded, read_record
from tuner.study.contest import Contest
from tuner.study.contest_reading import load_contest


def reopen_contest(path: Path, budget: int | None) -> tuple[Contest, Folder]:
    """Return the contest of a results folder and the folder for writing; StoreError where it cannot be had again."""
    if budget is not None:
        raise InputError(
            "the searches of a contest cannot be extended one by one; run the contest with another search.generations",
            key="--budget",
        )
    record = read_record(path)
    try:
        contest = load_contest(path / record.study)
    except InputError as error:
        raise StoreError(f"the inputs of this run are damaged: {error}") from None
    check_unchanged(path, record, contest.digest())
    compute_as_recorded(path, record, "run it anew")
    return contest, Folder.open(path)
