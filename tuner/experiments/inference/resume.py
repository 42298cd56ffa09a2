"""Go on with an inference: settings that were flown are recalled, the others flown."""

from pathlib import Path

from plant.errors import InputError, StoreError
from tuner.store.folder import Folder
from tuner.store.inputs import check_unchanged, compute_as_recorded, read_record
from tuner.study.inference import Inference
from tuner.study.inference_reading import load_inference


def reopen_inference(path: Path, budget: int | None) -> tuple[Inference, Folder]:
    """Return the inference of a results folder and the folder for writing; StoreError where it cannot be had again."""
    if budget is not None:
        raise InputError("an inference cannot be extended; run it with another search.generations", key="--budget")
    record = read_record(path)
    try:
        inference = load_inference(path / record.study)
    except InputError as error:
        raise StoreError(f"the inputs of this run are damaged: {error}") from None
    check_unchanged(path, record, inference.digest())
    compute_as_recorded(path, record, "run it anew")
    return inference, Folder.open(path)
