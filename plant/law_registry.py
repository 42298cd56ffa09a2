"""Control laws: one file a law, one line here. The cascade, the search and the reports learn of a law from this table."""

import sys
from importlib import import_module
from operator import attrgetter

from plant.entry_points import DISTRIBUTION, LAW_GROUP, entry_points
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
from plant.registry import Registry

# Laws to choose from first, those of this distribution's extensions last of them, then the paper's as printed.
MODULES = (
    pid,
    ladrc,
    adrc,
    supertwisting,
    supertwisting_euler,
    hybrid,
    hybrid_true_sta,
    *[import_module(name.partition(":")[0]) for _, name in entry_points(LAW_GROUP, sys.path, DISTRIBUTION)],
    hybrid_gsta,
    hybrid_literal,
    hybrid_paper_f_hat,
    hybrid_beta3,
    ladrc_printed,
)
LAWS: Registry[Law] = Registry("law", attrgetter("name"), [module.LAW for module in MODULES])


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
