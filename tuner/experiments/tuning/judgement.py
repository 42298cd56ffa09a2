"""A second judgement: flights already flown, judged by other objectives, risks, limits or pick rules.

What a run recorded are the meters of every flight, from which any metric follows. A candidate that the first study did not fly
and that the second finds worth it is flown; so are finalists on held-out scenarios that they have not seen.
"""

from collections.abc import Iterator

import numpy as np

from tuner.experiments.tuning.run import TuningRun
from tuner.search.loop import Search
from tuner.store.advice import JUDGEMENT


class Recorded:
    """A search that asks for the candidates of another one."""

    def __init__(self, generations: Iterator[np.ndarray]) -> None:
        self._generations = generations

    def ask(self) -> np.ndarray:
        """Return the next generation (n, d)."""
        return next(self._generations)

    def tell(self, values: np.ndarray, violations: np.ndarray) -> None:
        """Learn nothing: the candidates are given."""


class JudgementRun(TuningRun):
    """A tuning run that asks for recorded candidates. candidates: one array (n, d) a generation."""

    kind = JUDGEMENT
    options = frozenset()
    candidates: list[np.ndarray]

    def algorithm(self) -> tuple[Search, list[str]]:
        """Return the recorded search."""
        return Recorded(iter(self.candidates)), []
