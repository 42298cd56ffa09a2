"""How far a run came that has left no summary yet."""

import csv
from pathlib import Path
from typing import Any

from plant.errors import StoreError
from plant.input_files import read_input_text
from tuner.store.advice import CONTEST, RESUMED, mend, whole
from tuner.store.inputs import read_record

Row = dict[str, Any]


def unfinished_story(folder: Path) -> Row:
    """Return kind, title, generations and flights so far; StoreError where the folder is none of a run."""
    record = read_record(folder)
    story: Row = {"kind": record.kind, "finished": False, "title": title_of(folder / record.study)}
    if record.kind == CONTEST:
        own = sorted(path for path in folder.glob("contenders/*") if path.is_dir())
        story |= {
            "contenders_finished": [path.name for path in own if (path / "summary.json").exists()],
            "contenders_begun": [path.name for path in own if not (path / "summary.json").exists()],
        }
    else:
        last = last_generation(folder / "history.csv")
        story |= {
            "generations": record.generations,
            "generations_done": int(last["generation"]) + 1 if last else 0,
            "flights": int(last["flights"]) if last else 0,
            "seconds": float(last["seconds"]) if last else 0.0,
            "feasible_share": float(last["feasible_share"]) if last else None,
            "hypervolume": float(last["hypervolume"]) if last else None,
        }
    return story | {"commands": [f"tuner resume {whole(folder)}"] if record.kind in RESUMED else []}


def title_of(study: Path) -> str:
    """Return the title of a study; the name of the file where it cannot be read."""
    import tomllib

    try:
        return str(tomllib.loads(read_input_text(study))["title"])
    except (OSError, ValueError, KeyError):
        return study.name


def last_generation(file: Path) -> dict[str, str] | None:
    """Return the last row of history.csv, None before the first generation has ended."""
    try:
        rows = list(csv.DictReader(read_input_text(file).splitlines()))
    except FileNotFoundError:
        return None
    except (OSError, UnicodeDecodeError) as error:
        raise StoreError(f"{file} cannot be read ({error}); {mend(file.parent, file.name)}") from None
    return rows[-1] if rows else None
