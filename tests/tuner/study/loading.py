"""Contests by their kind, for tests that have written one."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tuner.extensions.contests.study import Contest
from tuner.study.kinds import load_any


def load_contest(path: Path, overrides: Mapping[str, Any] | None = None) -> Contest:
    """Load a file that holds a contest."""
    study = load_any(path, overrides)
    assert isinstance(study, Contest)
    return study
