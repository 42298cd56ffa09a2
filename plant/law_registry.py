"""Control laws: one file a law, one line here. The cascade, the search and the reports learn of a law from this table."""

from operator import attrgetter

from plant.laws import (
    adrc,
    hybrid,
    hybrid_beta3,
    hybrid_gsta,
    hybrid_literal,
    hybrid_paper_f_hat,
    hybrid_true_sta,
    ladrc,
    ladrc_printed,
    pid,
    supertwisting,
    supertwisting_euler,
)
from plant.laws.law import Law
from plant.quadrotor.autopilots import ardupilot, betaflight, crazyflie, px4, px4_position
from plant.registry import Registry

# Laws to choose from first, then the paper's as printed.
ENTRIES = (
    pid.LAW,
    ladrc.LAW,
    adrc.LAW,
    supertwisting.LAW,
    supertwisting_euler.LAW,
    hybrid.LAW,
    hybrid_true_sta.LAW,
    px4.LAW,
    px4_position.LAW,
    ardupilot.LAW,
    betaflight.LAW,
    crazyflie.LAW,
    hybrid_gsta.LAW,
    hybrid_literal.LAW,
    hybrid_paper_f_hat.LAW,
    hybrid_beta3.LAW,
    ladrc_printed.LAW,
)
LAWS: Registry[Law] = Registry("law", attrgetter("name"), ENTRIES)


def law(name: str) -> Law:
    """Return a control law.

    Args:
        name: Its name in `LAWS`, as `tuner list laws` prints it.

    Returns:
        The law with its functions and the description of its gains.

    Raises:
        UnknownNameError: There is no such law; the message names the nearest.
    """
    return LAWS.find(name)
