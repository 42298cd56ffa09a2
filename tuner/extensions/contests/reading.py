"""From a contest file to what runs; errors name the file and the key that a person has to change."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from objectives.metrics import MetricAddress, parse
from objectives.own_meters import check_on_flights
from objectives.problem import Constraint, Objective
from objectives.risk import Risk
from plant.errors import InputError, UnknownNameError
from plant.quadrotor.scenarios import CONFIRMATION
from plant.texts import PlainTable, PlainValue
from tuner.extensions.contests.study import Claim, Contest, HalvingSchedule, Published
from tuner.extensions.contests.tables import (
    CONTEST_TABLES,
    ClaimTable,
    ContenderTable,
    ContestTable,
    PublishedTable,
)
from tuner.extensions.contests.terms import check_alike, terms_of
from tuner.study.comparison import Contender, slug_of
from tuner.study.judged_reading import refuse_probability
from tuner.study.layers import REPLACED, Layer, depth, laid_over, merged, merged_layers
from tuner.study.messages import translated
from tuner.study.reading import put
from tuner.study.tuning_study import TuningStudy
from tuner.text.input_errors import check_magnitudes, listed, located, moved
from tuner.text.strict_table import StrictTable
from tuner.text.toml_text import tables_in

# Generations of the first rung: fronts of searches that begin with a Latin hypercube say little after two.
# `benchmarks/results/choices.md` has races of both.
MIN_GENERATIONS, MIN_GENERATIONS_FROM_STARTS = 4, 2
Tables = TypeVar("Tables", bound=StrictTable)


def contest_from_layers(path: Path, layers: tuple[Layer, ...], overrides: Mapping[str, PlainValue]) -> Contest:
    """Check a contest whose files have been read."""
    table = merged_layers(layers)
    for key, value in overrides.items():
        put_in_contest(table, key, value, path)
    return contest_from_table(path, table, layers)


def contest_from_table(path: Path, table: PlainTable, layers: tuple[Layer, ...] = ()) -> Contest:
    """Check the merged content of a contest; path: the file that errors name where no layer holds the key."""
    terms = terms_of(table)
    _refuse_shared(path, table, terms.individual, terms.shared)
    added = checked_tables(ContestTable, table, path)
    shared = {key: value for key, value in table.items() if key not in CONTEST_TABLES}
    contenders = evenly_started([_contender(i, entry, shared, path, layers) for i, entry in enumerate(added.contender)])
    with located(path, ""):
        _check_names(contenders)
        check_alike(contenders)
        judge = _Judge(contenders)
        published = tuple(judge.published(i, entry) for i, entry in enumerate(added.published))
        claims = tuple(judge.claim(i, entry, published) for i, entry in enumerate(added.claim))
    study, content = contenders[0].study, with_starts(table, contenders)
    with located(path, "halving"):
        halving = _halving(added, contenders)
    title = str(table.get("title"))
    return Contest(
        path, title, study.description, study.seed, contenders, CONFIRMATION, published, claims, content, halving
    )


def _halving(added: ContestTable, contenders: Sequence[Contender]) -> HalvingSchedule | None:
    """Return the halving of a contest; InputError where its contenders cannot be dropped."""
    if added.halving is None:
        return None
    if added.published or added.claim:
        raise InputError("contenders that a number or a claim is about cannot be dropped; leave [halving] out")
    given = [contender.name for contender in contenders if not contender.tuned]
    if given:
        raise InputError(
            f"nothing is searched for '{given[0]}', so that no search of it can be judged; leave [halving] out"
        )
    if added.halving.finalists >= len(contenders):
        message = f"given {added.halving.finalists}; allowed: fewer than the {len(contenders)} contenders"
        raise InputError(message, key="finalists")
    usual = (
        MIN_GENERATIONS_FROM_STARTS
        if all(contender.study.search.starts for contender in contenders)
        else MIN_GENERATIONS
    )
    return HalvingSchedule(added.halving.factor, added.halving.finalists, added.halving.least or usual)


def with_starts(table: PlainTable, contenders: Sequence[Contender]) -> PlainTable:
    """Return a contest's content with the starting points of tuned contenders."""
    search = table.get("search")
    shared = (
        {"search": {key: value for key, value in search.items() if key != "starts"}} if isinstance(search, dict) else {}
    )
    entries = [
        merged(entry, _starts_of(contender.study)) if contender.tuned else dict(entry)
        for entry, contender in zip(tables_in(table.get("contender")), contenders, strict=True)
    ]
    return {**table, **shared, "contender": [*entries]}


def evenly_started(contenders: Sequence[Contender]) -> tuple[Contender, ...]:
    """Return contenders, all or none of them with shipped fronts.

    Else those would be compared that have one with those that have none, and not their laws.
    """
    if all(contender.study.search.starts for contender in contenders if contender.tuned):
        return tuple(contenders)
    return tuple(
        contender if contender.study.names_starts or not contender.tuned else _without_starts(contender)
        for contender in contenders
    )


def _without_starts(contender: Contender) -> Contender:
    study = contender.study.without_starts()
    return replace(contender, study=study, raw=merged(contender.raw, _starts_of(study)))


def _starts_of(study: TuningStudy) -> PlainTable:
    """Return the table of a search's starting points."""
    return {"search": {"starts": study.start_tables}}


def checked_tables(model: type[Tables], table: PlainTable, path: Path) -> Tables:
    """Return those tables of a file that a model holds, checked."""
    given = {key: table[key] for key in model.model_fields if key in table}
    try:
        checked = model.model_validate(given)
    except ValidationError as error:
        raise translated(error, path, model) from None
    check_magnitudes(given, path)
    return checked


def _refuse_shared(path: Path, table: PlainTable, individual: tuple[str, ...], shared: tuple[str, ...]) -> None:
    """Say why a contender cannot have its own scenario, objective, ...; a misspelt key is found later."""
    entries = table.get("contender")
    for i, entry in enumerate(entries if isinstance(entries, list) else []):
        for key in shared:
            if depth(entry, key) == len(key.split(".")):
                message = (
                    f"'{key}' is the same for all contenders and stands at the top of the file; a contender's own are "
                )
                raise InputError(message + ", ".join(individual), file=path, key=f"contender[{i}].{key}")


def _contender(i: int, entry: ContenderTable, shared: PlainTable, path: Path, layers: tuple[Layer, ...]) -> Contender:
    slug = slug_of(entry.name)
    if not slug:
        message = f'given {entry.name!r}; write a name with a letter or digit, for instance name = "PID"'
        raise InputError(message, file=path, key=f"contender[{i}].name")
    terms = terms_of(shared)
    with located(path, f"contender[{i}]"):
        individual = terms.completed(shared, entry.tables())
    # Gains of the base may be of another law.
    raw = laid_over(shared, individual, (*REPLACED, "gains"))
    title = raw.get("title")
    if isinstance(title, str):
        raw |= {"title": f"{title}: {entry.name}"}
    try:
        study = terms.build(path, raw)
        tuple(listed("constraint", path, study.constraints, _refuse_probability))
    except InputError as error:
        raise _moved(error, i, individual, path, layers) from None
    if study.space.variables:
        raw = merged(raw, _starts_of(study))
    return Contender(entry.name, slug, study, raw)


def _refuse_probability(limit: Constraint) -> None:
    """Refuse a limit that flights of its own decide."""
    refuse_probability(limit.objective.risk.name, "takes a study of one controller; in a contest write")


def _moved(error: InputError, i: int, individual: PlainTable, path: Path, layers: tuple[Layer, ...]) -> InputError:
    """Return a contender's error with the file and key of the value."""
    if error.file != str(path) or error.key is None:
        return error
    key = error.key
    holders = [(path, f"contender[{i}].{key}", individual), *[(layer.path, key, layer.table) for layer in layers]]
    depths = [depth(table, key) for _, _, table in holders]
    file, where, _ = holders[depths.index(max(depths))] if max(depths) > 0 else (path, key, individual)
    return moved(error, file, where)


def _check_names(contenders: tuple[Contender, ...]) -> None:
    """Refuse names that cannot be distinguished."""
    for i, contender in enumerate(contenders):
        for j, other in enumerate(contenders[:i]):
            if contender.slug == other.slug:
                message = f"'{contender.name}' and '{other.name}' of contender[{j}] look alike; change one of the two"
                raise InputError(message, key=f"contender[{i}].name")


class _Judge:
    """Checks what contenders are judged by against the names there are."""

    def __init__(self, contenders: tuple[Contender, ...]) -> None:
        self._study = contenders[0].study
        self._names = [contender.name for contender in contenders]

    def published(self, i: int, entry: PublishedTable) -> Published:
        """Return a printed number."""
        with located(None, f"published[{i}]"):
            names = self._contenders(entry.contender, "contender")
            metric = self._metric(entry.metric, entry.scenario, "metric")
        return Published(names, metric, entry.scenario, entry.value, entry.source, entry.fitted)

    def claim(self, i: int, entry: ClaimTable, published: tuple[Published, ...]) -> Claim:
        """Return a claim."""
        study = self._study
        judged = [*study.objectives, *[c.objective for c in study.constraints], *[cell.objective for cell in published]]
        with located(None, f"claim[{i}]"):
            better = self._contenders([entry.better], "better")[0]
            than = self._contenders(entry.than, "than")
            if better in than:
                raise InputError(f"'{better}' cannot be better than itself; leave it out", key="than")
            claimed = [self._claimed(text, entry.scenario, judged) for text in entry.metrics]
        objectives = {objective.label: objective for group in claimed for objective in group}
        text = entry.text or f"{better} is better than {' and '.join(than)}"
        return Claim(better, than, tuple(objectives.values()), text)

    def _contenders(self, names: list[str], key: str) -> tuple[str, ...]:
        for i, name in enumerate(names):
            if name not in self._names:
                raise UnknownNameError("contender", name, self._names, key=key)
            if name in names[:i]:
                raise InputError(f"'{name}' occurs twice; remove one", key=key)
        return tuple(names)

    def _claimed(self, text: str, scenario: str | None, judged: list[Objective]) -> list[Objective]:
        """Return the objectives that a text of `in` names: by label, all judged ones of a metric, or else its mean."""
        exact = [objective for objective in judged if objective.label == text]
        if exact:
            return exact[:1]
        metric = self._metric(text, scenario, "in")
        same = [o for o in judged if o.metric.text == text and scenario in (None, o.scenario)]
        return same or [Objective(metric, Risk("mean"), scenario)]

    def _metric(self, address: str, scenario: str | None, key: str) -> MetricAddress:
        names = [entry.spec.name for entry in self._study.scenarios]
        if scenario is not None and scenario not in names:
            raise UnknownNameError("scenario", scenario, names, key="scenario")
        with located(None, key):
            metric = parse(address, self._study.system.axes)
            for entry in self._study.scenarios:
                if scenario in (None, entry.spec.name):
                    check_on_flights(metric, self._study.system, entry.spec)
        return metric


def put_in_contest(table: PlainTable, key: str, value: Any, path: Path) -> None:
    """Set a dotted key in the content of a contest: one of a study, contender.NAME.KEY or contender.0.KEY.

    Raises InputError where a contender or a list entry is not there.
    """
    match = re.fullmatch(r"contender(?:\[(\d+)\]|\.(.+?))(?:\.(.*))?", key)
    if match is None:
        put(table, key, value, path)
        return
    entry, rest = _named_contender(table, key, path)
    if not rest:
        raise InputError(
            "names a contender, but none of its keys; write for instance contender.0.pick.rule", file=path, key=key
        )
    try:
        put(entry, rest, value, path)
    except InputError as error:
        raise InputError(error.message, file=path, key=key) from None


def _named_contender(table: PlainTable, key: str, path: Path) -> tuple[PlainTable, str]:
    """Return a contender's table and what is left of the key; a name may hold dots, so the longest that fits is taken."""
    entries = tables_in(table.get("contender"))
    rest = re.sub(r"^\[(\d+)\]", r"\1", key.removeprefix("contender").removeprefix("."))
    number, _, behind = rest.partition(".")
    if number.isdecimal():
        if int(number) >= len(entries):
            raise InputError(f"there is no contender {number}; allowed: 0 to {len(entries) - 1}", file=path, key=key)
        return entries[int(number)], behind
    names = {str(entry.get("name")): entry for entry in entries}
    fitting = [name for name in names if rest == name or rest.startswith(f"{name}.")]
    if not fitting:
        raise UnknownNameError("contender", number, names, file=path, key=key)
    name = max(fitting, key=len)
    return names[name], rest[len(name) + 1 :]
