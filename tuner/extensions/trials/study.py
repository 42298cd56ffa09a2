"""A study whose trials another program makes: variables, metrics, budget, objectives and constraints.

The program may be a simulator or a test bench. Trials have the numbers of scenarios; each comes with a seed, the same for every
candidate, so that a program which draws its disturbances from it compares candidates in pairs. A metric is a number of a trial,
0 or more and better when smaller; one beyond its `worst` counts as that, and each metric of a failed trial as twice that.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf
from pathlib import Path
from typing import Annotated, ClassVar, NamedTuple

from pydantic import Field, ValidationError

from objectives.decisions import DecisionSpace, Variable
from objectives.metrics import MetricAddress
from objectives.metrics.metric import Metric
from objectives.problem import Constraint, Objective
from objectives.risk import RELEVANT
from plant.errors import InputError, UnknownNameError
from plant.seeds import generator
from plant.texts import PlainTable, PlainValue, check_name, check_texts, check_title
from tuner.study.certainty import CONFIDENCE, Confidence, Relevant
from tuner.study.earlier_front import read_variables
from tuner.study.judged_reading import held_with, pick_rule, refuse_probability, risk_of, unique
from tuner.study.layers import Layer
from tuner.study.messages import translated
from tuner.study.reading import put
from tuner.study.schema import PickTable, SearchTable
from tuner.study.search_reading import least_tail, search_of, with_reference
from tuner.study.searched import SearchedStudy, SearchSpec, StudyScenario, VariableWords
from tuner.study.size import CHECKED, MAX_FLIGHTS, check_candidates
from tuner.study.starts import EarlierGains
from tuner.text.input_errors import check_sizes, listed, located
from tuner.text.markup import element
from tuner.text.markup import table as markup_table
from tuner.text.sentences import listing
from tuner.text.strict_table import StrictTable
from tuner.text.units import after_number

# Trials of a run at most: the lines of all of them are held in memory.
MAX_TRIALS = 10_000_000
SEEDS = 2**31
"""Seeds of trials lie below this, so that they fit where a program keeps a seed in 32 bits with a sign."""
FAILED = 2.0
"""Cost of a failed trial, in the largest values that its metrics can have."""


class VariableTable(StrictTable):
    """[[variable]]: a number that is searched."""

    name: str
    """Name in the trials that the program gets."""
    low: float
    """Lower end of the range."""
    high: float
    """Upper end of the range."""
    default: float
    """Value that the search starts from and that everything is measured by."""
    scale: str = "linear"
    """Scale of the range: "log" or "linear"."""
    unit: str = "1"
    """Unit of the value."""
    meaning: str = ""
    """Words for the report."""


class MetricTable(StrictTable):
    """[[metric]]: a number of each trial that the program submits, 0 or more, better when smaller."""

    name: str
    """Name in the results that the program submits."""
    worst: Annotated[float, Field(gt=0.0)]
    """Largest value that counts; a failed trial counts as twice this."""
    unit: str = "1"
    """Unit of the value."""
    meaning: str = ""
    """Definition for the report."""


class TrialsTable(StrictTable):
    """[trials]: how many trials a candidate takes, each in a scenario with a seed of its own."""

    search: Annotated[int, Field(ge=1, le=MAX_FLIGHTS)] = 8
    """Trials of each candidate in the search."""
    held_out: Annotated[int, Field(ge=2, le=MAX_FLIGHTS)] = 32
    """Trials of a finalist in the held-out check at most, and as many for the confirmation."""


class TrialObjectiveTable(StrictTable):
    """[[objective]]: a metric's risk over the trials, to be made small."""

    metric: str
    """Metric, or "failure" for the share of failed trials."""
    risk: str = "mean"
    """Risk measure over the trials."""
    level: float | None = None
    """Level of the risk measure, above 0 and below 1, where it has one."""


class TrialConstraintTable(TrialObjectiveTable):
    """[[constraint]]: the same, not to exceed `max`."""

    max: Annotated[float, Field(ge=0.0)]
    """Largest value allowed, in the unit of the metric."""


class TrialSearchTable(SearchTable):
    """[search]: how the values are looked for."""

    racing: bool = False
    """Ask for the trials of a candidate in parts, and for no more of one that a better one surely beats; a generation then takes
    several rounds of asking."""


class TrialStudyTable(StrictTable):
    """A whole file of a study whose trials another program makes."""

    title: str
    """One line that names the study."""
    seed: Annotated[int, Field(ge=0, lt=2**63)]
    """Root of every random number."""
    trials: TrialsTable
    variable: Annotated[list[VariableTable], Field(min_length=1)]
    metric: Annotated[list[MetricTable], Field(min_length=1)]
    objective: Annotated[list[TrialObjectiveTable], Field(min_length=1)]
    description: str = ""
    """Text for the report."""
    confidence: Confidence = CONFIDENCE
    """Confidence of the interval whose upper end keeps each limit; 0: the value alone keeps it."""
    relevant: Relevant = RELEVANT
    """Share of a value from which a difference matters: better and worse differ by more, no practical difference by less."""
    constraint: list[TrialConstraintTable] = Field(default=[])
    search: TrialSearchTable = TrialSearchTable()
    pick: PickTable = PickTable()


class TrialSpec(NamedTuple):
    """Scenarios of the trials: they differ in their seed alone."""

    name: str = "trials"


@dataclass(frozen=True, kw_only=True)
class TrialStudy(SearchedStudy):
    """A study whose trials another program makes. metrics: what it tells of each, in the order of the file."""

    kind: ClassVar[str] = "trials"
    metrics: tuple[MetricAddress, ...]
    table: TrialStudyTable

    @property
    def variable_words(self) -> list[VariableWords]:
        """Symbol, meaning and unit of each variable."""
        return [VariableWords("", entry.meaning, entry.unit) for entry in self.table.variable]

    @cached_property
    def names(self) -> list[str]:
        """Names of the variables."""
        return [variable.name for variable in self.space.variables]

    def earlier_gains(self, file: Path) -> EarlierGains:
        """Return the values of a gains.json of trials by variable; InputError where it has none of these variables."""
        values = read_variables(file)
        if not set(values) & set(self.names):
            names = listing(self.names)
            message = (
                f"its variables are {listing(values)}, those of this study {names}; give a run of the same variables"
            )
            raise InputError(message, file=file, key="gains")
        return EarlierGains(values, dict.fromkeys(values, 1.0))

    def trial_seed(self, stream: str, scenario: int) -> int:
        """Return the seed of a stream's scenario, common to all candidates."""
        return int(generator(self.seed, f"trials/{stream}", scenario).integers(SEEDS))

    def _values(self) -> PlainTable:
        return {
            **self.table.model_dump(mode="json", by_alias=True),
            "search": self.search.values,
            "gains": dict(zip(self.names, self.space.base, strict=True)),
            "variables": [variable.content() for variable in self.space.variables],
        }

    def _repr_html_(self) -> str:
        rows = (
            ("variables", ", ".join(self.names)),
            ("objectives", ", ".join(entry.label for entry in self.objectives)),
            ("limits", ", ".join(entry.objective.label for entry in self.constraints)),
            ("search", f"{self.search.algorithm}, {self.search.size}"),
        )
        return element("div", element("strong", self.title), markup_table(("", f"seed {self.seed}"), rows))


def trials_from_layers(path: Path, layers: tuple[Layer, ...], overrides: Mapping[str, PlainValue]) -> TrialStudy:
    """Check a study of trials whose file has been read; InputError names file and key."""
    table = layers[0].table
    for key, value in overrides.items():
        put(table, key, value, path)
    try:
        checked = TrialStudyTable.model_validate(table)
    except ValidationError as error:
        raise translated(error, path, TrialStudyTable) from None
    check_title(checked.title, file=path, key="title")
    check_texts(table, file=path)
    check_sizes(table, path)
    with located(path, ""):
        return _built(path, checked)


def _built(path: Path, table: TrialStudyTable) -> TrialStudy:
    space = _space(table.variable)
    metrics = _metrics(table.metric)
    objectives = tuple(listed("objective", path, table.objective, lambda entry: _objective(entry, metrics)))
    unique("objective", [objective.label for objective in objectives])
    constraints = tuple(listed("constraint", path, table.constraint, lambda entry: _constraint(entry, metrics)))
    unique("constraint", [constraint.objective.label for constraint in constraints])
    constraints = held_with(table.confidence, constraints)
    with located(None, "search"):
        if "design" in table.search.initial:
            message = 'given "design", which needs a model of the plant; write initial = ["default"]'
            raise InputError(message, key="initial")
        tail = least_tail(objectives, scenarios=1)
        search = search_of(table.search, len(space.variables), len(objectives), table.trials.search, tail)
        search = with_reference(search, table.search, objectives)
        _check_size(search, table.trials)
    with located(None, "pick"):
        rule = pick_rule(table.pick, objectives)
    return TrialStudy(
        path=path,
        title=table.title,
        description=table.description,
        seed=table.seed,
        space=space,
        scenarios=(StudyScenario(TrialSpec(), table.trials.search, table.trials.held_out),),
        metrics=metrics,
        objectives=objectives,
        constraints=constraints,
        search=search,
        pick=rule,
        table=table,
    ).with_starts()


def _space(tables: list[VariableTable]) -> DecisionSpace:
    variables = []
    for i, entry in enumerate(tables):
        key = f"variable[{i}]"
        check_name(entry.name, key=f"{key}.name")
        try:
            variables.append(Variable(entry.name, (entry.name,), entry.low, entry.high, entry.scale))
        except InputError as error:
            raise InputError(error.message, key=key) from None
        if not entry.low <= entry.default <= entry.high:
            message = f"given {entry.default:g}; allowed: {entry.low:g} to {entry.high:g}, the range of the search"
            raise InputError(message, key=f"{key}.default")
    unique("variable", [variable.name for variable in variables], ".name")
    columns = tuple((i,) for i in range(len(variables)))
    return DecisionSpace(tuple(variables), columns, tuple(entry.default for entry in tables))


FAILURE = MetricAddress(
    "failure",
    Metric(
        name="failure",
        symbol="p_fail",
        unit="1",
        scope="flight",
        definition="1 if the trial failed, else 0; its mean over trials is the failure rate",
        value=lambda numbers: 0.0,
        bound=lambda numbers: 1.0,
        graded=False,
        highest=1.0,
        reaches_zero=True,
        is_binary=True,
        combine="max",
    ),
    (),
)
"""The metric that need not be submitted."""


def _metrics(tables: list[MetricTable]) -> tuple[MetricAddress, ...]:
    for i, entry in enumerate(tables):
        check_name(entry.name, key=f"metric[{i}].name")
        if entry.name == FAILURE.text:
            message = '"failure" is the share of failed trials, which is counted here; give the metric another name'
            raise InputError(message, key=f"metric[{i}].name")
    unique("metric", [entry.name for entry in tables], ".name")
    return tuple(_metric(entry) for entry in tables)


def _metric(table: MetricTable) -> MetricAddress:
    """Return the metric: its value is the submitted one, its bound the worst that counts."""
    name, worst = table.name, table.worst
    metric = Metric(
        name=name,
        symbol=name,
        unit=table.unit.replace("{", "{{").replace("}", "}}"),
        scope="flight",
        definition=table.meaning or "value that the program submits",
        value=lambda numbers: numbers[name],
        bound=lambda numbers: worst,
        highest=inf,
        reaches_zero=True,
    )
    return MetricAddress(name, metric, ())


def _objective(table: TrialObjectiveTable, metrics: tuple[MetricAddress, ...]) -> Objective:
    by_name = {entry.text: entry for entry in (*metrics, FAILURE)}
    if table.metric not in by_name:
        raise UnknownNameError("metric", table.metric, by_name, key="metric")
    refuse_probability(table.risk, "takes flights that are made here; for the share of failed trials write")
    return Objective(by_name[table.metric], risk_of(table.risk, table.level))


def _constraint(table: TrialConstraintTable, metrics: tuple[MetricAddress, ...]) -> Constraint:
    objective = _objective(table, metrics)
    most = objective.metric.metric.bound({})
    if table.max > most:
        unit = after_number(objective.metric.unit)
        message = f"given {table.max:g}; nothing worse than {most:g}{unit} counts: allowed: 0 to {most:g}{unit}"
        raise InputError(message, key="max")
    return Constraint(objective, table.max)


def _check_size(search: SearchSpec, trials: TrialsTable) -> None:
    """Refuse a run that is out of all proportion; InputError with the key inside [search]."""
    check_candidates(search.population, search.generations)
    count = search.candidates * trials.search + CHECKED * trials.held_out
    if count > MAX_TRIALS:
        message = f"about {count:,} trials in all; allowed: up to {MAX_TRIALS:,}: make generations or [trials] smaller"
        raise InputError(message)
