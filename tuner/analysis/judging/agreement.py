"""Whether a gains file and a file of requirements are about the same thing."""

from math import degrees
from pathlib import Path

from plant.errors import InputError
from tuner.gains import Controller
from tuner.study.study import Study

# Relative difference of periods and angles below which they are the same number.
SAME = 1e-9


def check_agreement(controller: Controller, gains: Path, study: Study) -> None:
    """Raise InputError naming all that differs between a controller and a study in airframe, laws, options and periods."""
    differing = differences(controller, study)
    if differing:
        raise InputError(
            f"what {gains} holds is not what this study flies: {'; '.join(differing)}; judge the gains by a study of their own "
            "controller, or tune them for this one",
            file=study.path, key="controller" if "airframe" not in differing[0] else "airframe",
        )  # fmt: skip


def differences(controller: Controller, study: Study) -> list[str]:
    """Return what differs, each as "NAME 'gains' instead of 'study'"."""
    system, timing = study.system, study.system.timing
    pairs: list[tuple[str, object, object]] = [
        ("airframe", controller.airframe.name, study.airframe.name),
        ("position law", controller.cascade.position.name, system.cascade.position.name),
        ("attitude law", controller.cascade.attitude.name, system.cascade.attitude.name),
        ("control_period [s]", controller.control_period, timing.control_period),
        ("plant_step [s]", controller.plant_step, timing.plant_step),
        ("tilt_limit_deg", degrees(controller.options.tilt_limit), degrees(study.options.tilt_limit)),
        *[
            (key, value, getattr(study.options, key))
            for key, value in vars(controller.options).items()
            if key != "tilt_limit"
        ],
    ]
    found = [f"{name} {_told(mine)} instead of {_told(its)}" for name, mine, its in pairs if not _same(mine, its)]
    if controller.airframe.name == study.airframe.name and controller.airframe.vehicle != study.airframe.vehicle:
        found.insert(
            0, f"airframe '{study.airframe.name}' has other numbers in the study's file than in the gains file"
        )
    return found


def _told(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else repr(value)


def _same(mine: object, its: object) -> bool:
    if isinstance(mine, float) and isinstance(its, float):
        return abs(mine - its) <= SAME * abs(its)
    return mine == its
