"""Loops of settings: the margins as `tuner margins --study` has them, and curves in the worst amplitude."""

from collections import OrderedDict
from functools import cached_property

import numpy as np

from objectives.margins.loop_margins import LoopMargins
from objectives.margins.trim import Trim
from plant.errors import InputError
from tuner.documents.margins import MarginsDocument
from tuner.documents.tuning_tables import Loop
from tuner.extensions.studio.session import Session, Setting

Array = np.ndarray
POINTS = 300
"""Frequencies of a curve; a chart has no more pixels."""
MAX_SETTINGS = 48
"""Settings whose curves and margins are kept."""


class LoopCurves:
    """Loops of the settings of a session."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._curves: OrderedDict[tuple[bytes, str], Loop] = OrderedDict()
        self._documents: OrderedDict[bytes, MarginsDocument] = OrderedDict()

    @cached_property
    def model(self) -> LoopMargins | None:
        """Margin model of the study, None where its loops have no margins."""
        try:
            return self._session.study.margin_model()
        except InputError:
            return None

    @cached_property
    def channels(self) -> list[str]:
        """Names of the channels with a loop."""
        if self.model is None:
            return []
        closed = {channel for block in self.model.blocks for channel in block}
        return [channel for channel in self.model.channels if channel in closed]

    @cached_property
    def _frequencies(self) -> Array:
        assert self.model is not None, "there are channels"
        return self.model.figure_frequencies(self.model.evaluate(self._session.default.row[None]), POINTS)

    def curve(self, setting: Setting, channel: str) -> Loop:
        """Return the curve of a channel in its worst amplitude.

        That is the one with the largest peak of the sensitivity.
        """
        key = (setting.row.tobytes(), channel)
        if key not in self._curves:
            self._curves[key] = self._worst(setting.row, channel)
            while len(self._curves) > MAX_SETTINGS:
                self._curves.popitem(last=False)
        return self._curves[key]

    def _worst(self, row: Array, channel: str) -> Loop:
        model, w = self.model, self._frequencies
        assert model is not None, "there are channels"
        loops = [model.loop(row, channel, case, w).loop for case in model.cases]
        worst = int(np.argmin([np.abs(1.0 + loop).min() for loop in loops]))
        return Loop("", channel, True, {}, model.cases[worst].label if len(loops) > 1 else "", w, loops[worst])

    def margins(self, setting: Setting) -> MarginsDocument:
        """Return the margins of a setting.

        They are those of `tuner margins GAINS --study STUDY --json`.
        """
        key = setting.row.tobytes()
        if key not in self._documents:
            gains = self._session.gains(setting.row)
            self._documents[key] = gains.judge_margins(Trim(), self._session.study, False)[1]
            while len(self._documents) > MAX_SETTINGS:
                self._documents.popitem(last=False)
        return self._documents[key]
