"""Loops of settings: the margins as `tuner margins` has them, and curves in the worst steady state and amplitude."""

from functools import cached_property
from typing import cast

import numpy as np

from objectives.margins.describing import Case
from objectives.margins.loop_margins import LoopMargins
from objectives.margins.plant_margins import PlantMargins
from objectives.margins.trim import Trim
from plant.errors import InputError
from tuner.analysis.margins.document import margins_document, plant_margins_document
from tuner.analysis.margins.readings import PlantSubject, subject_of
from tuner.documents.margins import MarginsDocument
from tuner.documents.tuning_tables import Loop
from tuner.extensions.studio.flights import Recent
from tuner.extensions.studio.session import Session, Setting
from tuner.study.margins import nominal_margins
from tuner.study.plant_study import PlantStudy
from tuner.study.study import Study
from tuner.study.trim import steady_states

Array = np.ndarray
Place = tuple[str, LoopMargins, Case]
"""Name of a steady state, the loops there, and an amplitude."""
POINTS = 300
"""Frequencies of a curve; a chart has no more pixels."""
COARSE = 4
"""Step between the frequencies that are looked at first."""


class LoopCurves:
    """Loops of the settings of a session."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._curves = Recent[tuple[bytes, str], Loop]()
        self._documents = Recent[bytes, MarginsDocument]()
        self._latest: dict[str, Place] = {}

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
    def _places(self) -> list[Place]:
        """Steady states and amplitudes of the study's loops."""
        assert self.model is not None, "there are channels"
        models = {"": self.model}
        if self._session.has_rotors:
            study = cast("Study", self._session.study)
            system = study.system
            models = {
                state.name: nominal_margins(
                    system.cascade, system.nominal, system.timing, system.vehicle, state.trim, False
                )
                for state in steady_states([entry.spec for entry in study.scenarios], system)
            }
        return [(name, model, case) for name, model in models.items() for case in model.cases]

    @cached_property
    def _frequencies(self) -> Array:
        assert self.model is not None, "there are channels"
        return self.model.figure_frequencies(self.model.evaluate(self._session.default.row[None]), POINTS)

    def curve(self, setting: Setting, channel: str, rests: bool = True) -> Loop:
        """Return the curve of a channel where it is worst: with the largest peak of the sensitivity.

        rests: whether all steady states and amplitudes are looked at, not only the worst of the latest setting that rested.
        """
        key = (setting.row.tobytes(), channel)
        if not rests and key not in self._curves and channel in self._latest:
            return self._drawn(setting.row, channel, self._latest[channel])
        return self._curves.get_or_make(key, lambda: self._worst(setting.row, channel))

    def _worst(self, row: Array, channel: str) -> Loop:
        """Return the curve that comes nearest to -1.

        A quarter of the frequencies finds where each is nearest, those around it how near; 24 full curves took 0.2 s.
        """
        place = min(self._places, key=lambda each: self._distance(row, channel, each))
        self._latest[channel] = place
        return self._drawn(row, channel, place)

    def _distance(self, row: Array, channel: str, place: Place) -> float:
        _, model, case = place
        w = self._frequencies

        def distances(at: slice) -> Array:
            return np.abs(1.0 + model.loop(row, channel, case, w[at]).loop)

        near = COARSE * int(np.argmin(distances(slice(None, None, COARSE))))
        return float(distances(slice(max(near - COARSE, 0), near + COARSE + 1)).min())

    def _drawn(self, row: Array, channel: str, place: Place) -> Loop:
        state, model, case = place
        names = [state] * bool(state) + [case.label] * (len(model.cases) > 1)
        w = self._frequencies
        return Loop("", channel, True, {}, ", ".join(names), w, model.loop(row, channel, case, w).loop)

    def margins(self, setting: Setting) -> MarginsDocument:
        """Return the margins of a setting's loops: those of `tuner margins`, at hover; limits have rows of their own."""
        return self._documents.get_or_make(setting.row.tobytes(), lambda: self._judged(setting.row))

    def _judged(self, row: Array) -> MarginsDocument:
        study = self._session.study
        if self._session.has_rotors:
            return margins_document(subject_of(cast("Study", study).controller(row), Trim()), [])
        # One model for all settings: a new one for each stays in caches of rebound functions, 40 KB a move.
        model = cast("PlantMargins", self.model)
        subject = PlantSubject(row, model, model.evaluate(row[None]), cast("PlantStudy", study).system)
        return plant_margins_document(subject, [])
