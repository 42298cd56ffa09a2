"""`python -m tests.golden.write` writes the kept outputs anew and prints every difference to what was kept before."""

import tempfile
from pathlib import Path

from tests.golden.comparing import KEPT, differences, encoded, folded, kept, kept_names, updated
from tests.golden.made import documents, help_texts
from tests.golden.steps import SLOW_STEPS, STEPS


def write() -> None:
    """Run every step and bring the kept files up to date."""
    with tempfile.TemporaryDirectory() as folder:
        made = {**help_texts(), **documents(Path(folder) / "work", (*STEPS, *SLOW_STEPS))}
    before = {name: kept(name) for name in kept_names()}
    for name in sorted({*before} - {*made}):
        (KEPT / name).unlink()
        print(f"{name}: gone")
    new = {name: updated(before.get(name), made[name]) for name in sorted(made)}
    for name, document in folded(new).items():
        if name not in before:
            print(f"{name}: new")
        for line in differences(before.get(name, made[name]), made[name]):
            print(f"{name}: {line}")
        path = KEPT / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(encoded(document), encoding="utf-8")


if __name__ == "__main__":
    write()
