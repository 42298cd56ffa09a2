"""Individual and shared parts of a contest's contenders, quadrotors or plants."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from plant.errors import InputError, UnknownNameError
from plant.texts import PlainTable, PlainValue
from tuner.study.build import study_from_table
from tuner.study.comparison import Contender
from tuner.study.layers import merged
from tuner.study.plant_schema import PlantStudyTable
from tuner.study.plant_study import PlantStudy, plant_study_from_table
from tuner.study.schema import StudyTable
from tuner.study.study import TuningStudy
from tuner.text.toml_text import tables_in


@dataclass(frozen=True)
class Terms:
    """Terms of a contest.

    individual: tables of a study that a contender may have of its own; shared: keys that are the same for all.
    build(path, content): the study of a contender. completed(base, tables): its own tables as they lie over those of the base.
    """

    individual: tuple[str, ...]
    shared: tuple[str, ...]
    build: Callable[[Path, Mapping[str, PlainValue]], TuningStudy]
    completed: Callable[[PlainTable, PlainTable], PlainTable]


def _with_channels(base: PlainTable, individual: PlainTable) -> PlainTable:
    """Return a contender's tables with the channels of the base.

    The contender's keys are laid over the channels by name, where it gives such.
    """
    given, base_channels = individual.get("channel"), base.get("channel")
    if not isinstance(given, dict) or not isinstance(base_channels, list):
        return individual
    channels = tables_in(base_channels)
    names = [str(entry.get("name")) for entry in channels]
    for name in given:
        if name not in names:
            raise UnknownNameError("channel", name, names, key=f"channel.{name}")
    over = {name: keys for name, keys in given.items() if isinstance(keys, Mapping)}
    return {**individual, "channel": [merged(entry, over.get(str(entry.get("name")), {})) for entry in channels]}


OF_QUADROTORS = ("airframe", "controller", "gains", "search", "pick")
OF_PLANTS = ("channel", "gains", "search", "pick")
QUADROTOR = Terms(
    OF_QUADROTORS,
    (*[key for key in StudyTable.model_fields if key not in OF_QUADROTORS], "controller.control_period"),
    study_from_table,
    lambda _, individual: individual,
)
PLANT = Terms(
    OF_PLANTS,
    tuple(key for key in PlantStudyTable.model_fields if key not in OF_PLANTS),
    plant_study_from_table,
    _with_channels,
)


def terms_of(content: PlainTable) -> Terms:
    """Return the terms of a contest by its tables."""
    return PLANT if PlantStudy.kind in content else QUADROTOR


def check_alike(contenders: Sequence[Contender]) -> None:
    """Refuse contenders that are not judged alike: who follow other references, or are lost at another error."""
    judged = [contender.study.followed for contender in contenders]
    for i, channels in enumerate(judged):
        if channels != judged[0]:
            first, this = (", ".join(map(str, each)) for each in (judged[0], channels))
            raise InputError(
                f"'{contenders[i].name}' is judged by {this}, '{contenders[0].name}' by {first}; give the "
                "channels that follow references one name, output and limit in all of them",
                key=f"contender[{i}].channel",
            )
