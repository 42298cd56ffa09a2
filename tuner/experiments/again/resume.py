"""Resume a run of any kind by replay of its search.

The search proposes its candidates again and takes the recorded flights as results. The outcome is that of a run that
was never interrupted, to the bit: nothing of the search's inner state is stored that could be stale, and a file that
was damaged is flown again. For runs that were stopped, killed, ran out of disk, or shall search longer.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, Unpack

from plant.errors import InputError, StoreError, UnnamedCodeError
from tuner.experiments.options import ResumeOptions
from tuner.experiments.registry import CompletedRun, completed, experiments, refuse_options
from tuner.extension import refuse_lacking
from tuner.search.watcher import Watcher, default_watcher
from tuner.store.advice import FLOWN_AGAIN, RECORD, RESUMED, TRIALS, is_codeless
from tuner.store.folder import Folder
from tuner.store.inputs import RunRecord, as_recorded, check_model, check_unchanged, compute_as_recorded, read_record
from tuner.study.kinds import AnyStudy, load_any, load_gains_study
from tuner.study.tuning_study import TuningStudy

S = TypeVar("S", bound=AnyStudy | TuningStudy)


def resume(path: Path, watcher: Watcher | None = None, **options: Unpack[ResumeOptions]) -> CompletedRun:
    """Go on with the run in a results folder to its end; StoreError where it cannot be continued."""
    watcher, record = watcher or default_watcher(), read_record(path)
    _refuse_others(path, record, RESUMED)
    kind = experiments()[record.kind]
    refuse_options(kind, **options)
    study, folder = reopen(path, options.get("budget"), options.get("search_flights"), options.get("recompute", False))
    with kind.run.engine_for(study, watcher, path, **options) as engine:
        watcher.on_start(study, path, kind.run.notes(study))
        return completed(kind.run(study, folder, watcher, engine, **options), kind)


def recorded_study(path: Path) -> tuple[TuningStudy, RunRecord]:
    """Return a run's study and record, and set the run's arithmetic.

    The study is as it was run. Raises StoreError where study or arithmetic cannot be had again, or where the folder is
    of another kind.
    """
    record = read_record(path)
    _refuse_others(path, record, FLOWN_AGAIN)
    study = _study_again(path, record, _gains_study)
    compute_as_recorded(path, record)
    return study, record


def reopen(
    path: Path, budget: int | None, search_flights: int | None = None, recompute: bool = False
) -> tuple[Any, Folder]:
    """Return the study of a results folder, and the folder for writing.

    Args:
        path: The results folder.
        budget: Number of generations, None for that of the run.
        search_flights: Flights of each scenario in the search, None for those of the run.
        recompute: Whether to compute with this machine's arithmetic; what another recorded has other keys, so all of it
            is computed again.
    """
    record = read_record(path)
    _refuse_others(path, record, RESUMED)
    load: Callable[[RunRecord, Path], AnyStudy | TuningStudy] = (
        _gains_study if record.kind in FLOWN_AGAIN else _any_study
    )
    study = _study_again(path, record, load)
    check_model(path, record)
    if not recompute:
        compute_as_recorded(path, record, None if record.kind in FLOWN_AGAIN else "run it again")
    folder = Folder.open(path)
    extended = _extended(record, study, budget, search_flights)
    if extended == record:
        return study, folder
    longer = load(extended, path / record.study)
    folder.write_json(RECORD, extended.model_copy(update={"digest": longer.digest()}))
    return longer, folder


def _extended(record: RunRecord, study: Any, budget: int | None, search_flights: int | None) -> RunRecord:
    """Return the record of a longer search; InputError where it would be a shorter one."""
    if budget is not None and record.generations is not None and budget < record.generations:
        raise InputError(
            f"given {budget} generations; the run has {record.generations}; a search can only be extended",
            key="--budget",
        )
    changes = {} if budget is None else {"generations": budget}
    if search_flights is not None:
        most = max(entry.search for entry in study.scenarios)
        if search_flights < most:
            raise InputError(
                f"given {search_flights} flights; the search made up to {most} of a scenario, flights can only be added",
                key="--search-flights",
            )
        changes |= {} if search_flights == most else {"search_flights": search_flights}
    return record.model_copy(update=changes)


def _refuse_others(path: Path, record: RunRecord, kinds: tuple[str, ...]) -> None:
    refuse_lacking("experiments", record.kind, file=path)
    if record.kind == TRIALS:
        raise StoreError(
            f"another program runs the trials of {path}; `tuner ask {path / 'study.toml'} --out {path}` prints pending ones"
        )
    if is_codeless(path):
        raise StoreError(
            f"no file holds the plant that was run into {path}, as in a notebook; run it there again, or write it to a file first"
        )
    if record.kind not in kinds:
        raise StoreError(
            f"{path} is the folder of a {record.kind}; give that of a tuning run, such as one in its contenders/"
        )


def _study_again(path: Path, record: RunRecord, load: Callable[[RunRecord, Path], S]) -> S:
    """Return the study that a run began with; StoreError where it is no longer what it was."""
    file = path / record.study
    try:
        study = load(record, file)
    except UnnamedCodeError:
        raise
    except InputError as error:
        raise StoreError(f"the inputs of this run are damaged: {error}") from None
    check_unchanged(path, record, study.digest())
    return study


def _any_study(record: RunRecord, file: Path) -> AnyStudy:
    return load_any(file, as_recorded(record, file))


def _gains_study(record: RunRecord, file: Path) -> TuningStudy:
    """Return a gains study with limits in the units of its record."""
    study = load_gains_study(file, "tuner resume", as_recorded(record, file))
    return study if record.si else study.in_units_of_limits()
