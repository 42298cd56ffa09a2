"""Files of user code, put into the registries.

A study or a command line names them: a law, a metric or a reference, by what the file defines: LAW, METRIC or REFERENCE.
A results folder never runs code that the user did not name: a study that is read from one gets what has been named before, by
its digest.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from objectives.metrics import METRICS, Metric
from objectives.metrics.contract import check_metric, violations_of_metric
from objectives.plant_system import PlantSystem
from plant.contract.law_contract import check_law, violations_of_law
from plant.contract.plant_contract import violations_of_plant
from plant.contract.reference_contract import check_reference, violations_of_reference
from plant.contract.violation import ContractViolation
from plant.errors import InputError, UnnamedCodeError
from plant.law_registry import LAWS
from plant.laws.law import Law
from plant.model.plant_model import PlantModel, PlantRecords, plant_from
from plant.own_code import OwnCode, run_own_code
from plant.references import REFERENCES, ReferenceSpec
from plant.registry import Registry
from tuner.extension import added, find
from tuner.gains.quantities import UCUM
from tuner.study.files import is_shipped
from tuner.study.reading import parse_toml
from tuner.study.schema import OwnCodeTable

if TYPE_CHECKING:
    from tuner.study.plant_schema import PlantTable


@dataclass(frozen=True)
class OwnKind:
    """A kind of object that a file may define.

    Attributes:
        noun: Noun of the kind, also its table in a study.
        name: Name of the object in the file.
        registry: Registry that takes the object.
        check: Function that refuses what could not be flown.
        breaches: Function that returns all violations of its contract.
    """

    noun: str
    name: str
    registry: Registry[Any]
    check: Callable[[Any, str], Any]
    breaches: Callable[[Any, str], list[ContractViolation]]


def _check_law(entry: Any, file: str) -> Law:
    if not isinstance(entry, Law):
        raise InputError(f"LAW is {entry!r}; it must be Law(name=..., step=...), of plant.laws.law", file=file)
    for breach in _unit_breaches(entry):
        raise InputError(breach.message, file=file, key=breach.part)
    return check_law(entry, file)


def _unit_breaches(entry: Law) -> list[ContractViolation]:
    return [
        ContractViolation(
            "Gains",
            f"the gain '{gain.name}' has the unit {gain.unit!r}, for which gains.json has no code; allowed: {_units()}",
        )
        for gain in entry.gains
        if not {gain.unit_in("attitude"), gain.unit_in("position")} <= UCUM.keys()
    ]


def _units() -> str:
    """Return the allowed units of a gain, {y} meaning rad or m."""
    return ", ".join(dict.fromkeys(unit.replace("rad", "{y}") for unit in UCUM if "m" not in unit.replace("rad", "")))


def _law_breaches(entry: Any, file: str) -> list[ContractViolation]:
    if not isinstance(entry, Law):
        return [ContractViolation("LAW", f"is {entry!r}; it must be Law(name=..., step=...), of plant.laws.law", file)]
    return [breach._replace(place=file) for breach in _unit_breaches(entry)] or violations_of_law(entry, file)


OWN_KINDS = (
    OwnKind("law", "LAW", LAWS, _check_law, _law_breaches),
    OwnKind("metric", "METRIC", METRICS, check_metric, violations_of_metric),
    OwnKind("reference", "REFERENCE", REFERENCES, check_reference, violations_of_reference),
)
PLANT_NOUN, PLANT = "plant", "derivative"
"""Table of a study that names the file of a plant, and the name in the file that tells it."""
TABLES = tuple(kind.noun for kind in OWN_KINDS)
"""Tables of a study that name files of code."""


SystemMaker = Callable[..., PlantSystem]


class PlantFile(Protocol):
    """File of a plant that the user named; nothing of it has run."""

    @property
    def file(self) -> Path:
        """Path of the file."""
        ...

    @property
    def digest(self) -> str:
        """Digest of its bytes."""
        ...


class PlantSource(NamedTuple):
    """Plants that an extension reads from files of one ending.

    Its name in records is that ending, and the key of [plant] that names such a file.

    Attributes:
        name: Function that takes a file that the user names and returns the content of `use`.
        read: Function of a file, its table and its study that returns plant, digest and class of its system.
        describe: Function that returns the content that `tuner check` shows of a file.
    """

    name: Callable[[Path], PlantFile]
    read: Callable[[Path, "PlantTable", Path], tuple[PlantRecords, str, SystemMaker]]
    describe: Callable[[Path], dict[str, Any]]


def plant_source(file: Path) -> PlantSource | None:
    """Return the extension's source of plants for files of this ending, or None."""
    name = file.suffix[1:]
    return find("plants", "kind of plant", name) if name in added("plants") else None


def use(file: str | Path) -> Law | Metric | type[ReferenceSpec] | PlantModel | PlantFile:
    """Run your file and register its content.

    Its law, metric or reference is then available by name to studies, gains and everything else.

    Args:
        file: A Python file that defines LAW, METRIC or REFERENCE, or a plant; or an FMU, of which nothing runs yet.

    Returns:
        Kind of its definition.

    Raises:
        InputError: It cannot be run or used; the message names file and line.

    Examples:
        >>> tuner.use("my_law.py").name  # doctest: +SKIP
        'my_law'
    """
    source = plant_source(Path(file))
    if source is not None:
        return source.name(Path(file))
    code = run_own_code(Path(file))
    return plant_from(code.names, code.file.stem, str(code.file)) if PLANT in code.names else _take(code, OWN_KINDS)


def use_named(file: Path) -> None:
    """Take a file of code, or all that a study names: of a study in a results folder too, because this is where the user names
    it.
    """
    if file.suffix != ".toml":
        use(file)
        return
    table = parse_toml(file)
    for kind in OWN_KINDS:
        for name in _files_in(table.get(kind.noun)):
            _take(run_own_code(file.parent / name), (kind,))
    for key in ("file", *added("plants")):
        for name in _files_in(table.get(PLANT_NOUN), key):
            use(file.parent / name)


def code_named(content: Mapping[str, Any]) -> list[str]:
    """Return the names of the code files in a study's content."""
    return [Path(file).name for noun in (*TABLES, PLANT_NOUN) for file in _files_in(content.get(noun))]


def _files_in(table: Any, key: str = "file") -> list[str]:
    """Return the files that an unchecked table of a study names."""
    given = table.get(key) if isinstance(table, dict) else None
    return [name for name in (given if isinstance(given, list) else [given]) if isinstance(name, str)]


def use_files_of(study: Path, tables: Mapping[str, OwnCodeTable | None]) -> None:
    """Take the files that the tables of a study name; study: its path, which they are relative to.

    Raises InputError with the key, and UnnamedCodeError where the user has to name them and has not.
    """
    for kind in OWN_KINDS:
        table = tables.get(kind.noun)
        for name in [] if table is None else table.files:
            _take(_code_beside(study, name, kind.noun), (kind,))


def _code_beside(study: Path, name: str, noun: str) -> OwnCode:
    """Run a file that a study names; one that is not there is a mistake of the study."""
    file = study.parent / name
    try:
        return run_own_code(file, None if is_shipped(file) else study)
    except UnnamedCodeError:
        raise
    except InputError as error:
        if error.file != str(file):
            raise
        message = f"{file}: {error.message}; the path is relative to the study file"
        raise InputError(message, key=f"{noun}.file") from error.__cause__


@dataclass(frozen=True)
class Examination:
    """Faults of a file by the contract of its kind.

    noun: of its kind. name: of what it defines, "" to announce nothing.
    """

    noun: str
    name: str
    digest: str
    breaches: list[ContractViolation]


def examine_own(file: Path) -> Examination:
    """Run a file and hold it against the contract of its kind; what keeps it is known by its name from then on."""
    code = run_own_code(file)
    if PLANT in code.names:
        return Examination(PLANT_NOUN, file.stem, code.digest, violations_of_plant(code.names, file.stem, str(file)))
    kind = _kind_of(code, OWN_KINDS)
    entry = code.names[kind.name]
    broken = kind.breaches(entry, str(file))
    if not broken:
        entry = _take(code, (kind,))
    name = getattr(entry, "name", getattr(entry, "kind", ""))
    return Examination(kind.noun, str(name), code.digest, broken)


def _take(code: OwnCode, kinds: tuple[OwnKind, ...]) -> Any:
    kind = _kind_of(code, kinds)
    entry = kind.check(code.names[kind.name], str(code.file))
    return kind.registry.add(entry, code.origin)


def _kind_of(code: OwnCode, kinds: tuple[OwnKind, ...]) -> OwnKind:
    matching = [kind for kind in kinds if kind.name in code.names]
    wanted = " or ".join(kind.name for kind in kinds)
    if not matching:
        raise InputError(
            f"defines no {wanted}; write {kinds[0].name} = ... at its end", file=code.file, key=kinds[0].name
        )
    if len(matching) > 1:
        raise InputError(
            f"defines {' and '.join(kind.name for kind in matching)}; put each into a file of its own",
            file=code.file,
            key=matching[0].name,
        )
    return matching[0]
