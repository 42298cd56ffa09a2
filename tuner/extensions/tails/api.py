"""Tails: how often an event of a flight happens, down to one in a million flights."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from plant.errors import InputError
from tuner.analysis.judged_metrics import shown_metrics
from tuner.api.flight_setup import FlightSetup, spec_of
from tuner.api.frames import Documented, figures, frame, shown
from tuner.api.gains import Gains, as_gains
from tuner.api.studies import StudyLike, gains_study
from tuner.extensions.tails.document import TailDocument
from tuner.extensions.tails.events import FAILURE
from tuner.extensions.tails.run import TailRun, TailSettings, TailSubject
from tuner.search.watcher import Watcher, default_watcher
from tuner.study.files import shipped_studies
from tuner.study.kinds import AnyStudy

if TYPE_CHECKING:
    import pandas as pd

    from tuner.report.charts.paper import Figure

DEFAULT_PROBABILITY, DEFAULT_WIDTH, MAX_FLIGHTS = 1e-6, 0.5, 1_000_000
MIN_PROBABILITY, MAX_PROBABILITY = 1e-9, 0.1
GainsOrStudy: TypeAlias = Gains | AnyStudy | str | Path


@dataclass(frozen=True)
class Tail(Documented):
    """Probabilities of events.

    Attributes:
        document: Output of `tuner tail --json`.
        folder: Folder of tail.json and the flights of the design points, None if none was written.

    """

    document: TailDocument
    folder: Path | None = None

    @cached_property
    def table(self) -> "pd.DataFrame":
        """A row for each of the gains and events: probability with its 95 % interval, flights."""
        rows = [
            {
                "gains": gains.gains,
                "event": event.event,
                "probability": event.probability,
                "low": event.low,
                "high": event.high,
                "flights": event.flights,
                "status": event.status,
            }
            for gains in self.document.gains
            for event in gains.events
        ]
        return frame(rows, ["gains", "event"])

    def figure(self) -> "Figure":
        """Draw the probability of exceeding a level.

        Returns:
            The figure, made without pyplot.

        Examples:
            >>> tuner.tail(gains, "peak.position > 1.3", to=0.05, most=500).figure().savefig("tail.png")

        """
        return figures("tail", self.document).draw("tail")

    def _repr_html_(self) -> str:
        return shown(f"Tails: {self.document.scenario}", (), self.table)


def tail(
    gains: GainsOrStudy | Sequence[GainsOrStudy],
    events: str | Sequence[str] = FAILURE,
    *,
    to: float = DEFAULT_PROBABILITY,
    width: float = DEFAULT_WIDTH,
    most: int = MAX_FLIGHTS,
    study: StudyLike | None = None,
    scenario: int = 0,
    seed: int = 1,
    worst: str | None = None,
    out: str | Path | None = None,
    watcher: Watcher | None = None,
    threads: int | None = None,
    dask: str | None = None,
) -> Tail:
    """Estimate how often events of a flight happen, with intervals.

    Args:
        gains: Gains, a gains.json, a results folder, or a study for its default; several are compared with the first on the
            same seeds.
        events: Events such as "peak.position > 3", in the unit of the metric, or "failure", which is split into its modes.
        to: Probability down to which is looked.
        width: Width of the 95 % interval, over the probability.
        most: Flights of each event at most.
        study: Study whose scenario, limits and seed are flown; by default that of the gains as of `fly`.
        scenario: Number of a scenario of the study, from 0.
        seed: Root seed where no study gives one.
        worst: Part of a flight, such as "vehicle" or "air", whose design point is sought with all else as usual; by default of
            all parts together.
        out: Folder for tail.json, the replicas and the flights of the design points. The same call goes on with it.
        watcher: Callbacks that hear of compilation, cost and flights.
        threads: Threads, by default one for each core; the result has the same bits on any number.
        dask: Cluster that runs the replicas of splitting, as of `run`; the result has the same bits.

    Returns:
        Probability, interval, shares of the modes and design points of each event.

    Raises:
        InputError: Gains, study or event are wrong, or no flight can have such an event.
        StoreError: The folder holds something else.

    Examples:
        >>> made = tuner.tail("quickstart", "peak.position > 1.3", to=0.05, most=500)
        >>> made.document.gains[0].events[0].probability < 0.5
        True

    """
    if not MIN_PROBABILITY <= to <= MAX_PROBABILITY:
        raise InputError(f"given {to:g}; allowed: {MIN_PROBABILITY:g} to {MAX_PROBABILITY:g}", key="--to")
    if not 0.05 <= width <= 10.0:
        raise InputError(f"given {width:g}; allowed: 0.05 to 10", key="--width")
    if most < 1:
        raise InputError(f"given {most}; allowed: at least one flight", key="--most")
    several = list(gains) if isinstance(gains, Sequence) and not isinstance(gains, str) else [gains]
    written = [events] if isinstance(events, str) else list(events)
    if not several or not written:
        raise InputError('give gains and an event, for instance --event "peak.position > 3"', key="--event")
    if len(set(written)) < len(written):
        raise InputError("an event is given twice; leave one out", key="--event")
    setups = [_setup(each, study, scenario, seed) for each in several]
    first = setups[0]
    for given, setup in zip(several, setups, strict=True):
        if setup.spec != first.spec or setup.root != first.root:
            raise InputError("the gains fly different scenarios; name one with --study", key=str(given))
    run = TailRun(
        [
            TailSubject(name, each.system, each.gains, each.laws)
            for name, each in zip(_names(several), setups, strict=True)
        ],
        written,
        first.spec,
        TailSettings(first.root, to, width, most, threads, worst, dask),
        watcher or default_watcher(),
        None if out is None else Path(out),
    )
    return Tail(run.carry_out(), None if out is None else Path(out))


def _setup(given: GainsOrStudy, study: StudyLike | None, scenario: int, seed: int) -> FlightSetup:
    """Return the flights of gains, or of the default of a study."""
    if isinstance(given, Gains) or (isinstance(given, str | Path) and not _is_study(given)):
        return as_gains(given).flight_setup(study, scenario, seed)
    default = gains_study(given, "tuner tail")
    spec = spec_of(default if study is None else gains_study(study, "tuner tail --study"), scenario)
    laws = dict(default.about)["laws"]
    return FlightSetup(
        default.system, default.default_row, spec, default.seed, laws, shown_metrics(default.system, spec)
    )


def _is_study(given: str | Path) -> bool:
    path = Path(given)
    return path.suffix == ".toml" or (not path.exists() and str(given) in shipped_studies())


def _names(several: Sequence[GainsOrStudy]) -> list[str]:
    """Return a name for each of the gains: as given, or its number."""
    names = []
    for number, given in enumerate(several, start=1):
        place = given if isinstance(given, str | Path) else given.path
        name = str(number) if place is None else str(place)
        names.append(name if isinstance(given, str | Path | Gains) else Path(name).stem)
    if len(set(names)) < len(names):
        raise InputError("gains are given twice; leave one out", key="GAINS")
    return names
