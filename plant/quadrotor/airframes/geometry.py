"""Places and turning senses of rotors by frame; body axes FLU.

    x, wide-x:  1 front left, 2 front right, 3 rear left, 4 rear right
    plus:       1 front,      2 right,       3 left,      4 rear       (the x frame turned by -45 degrees about z)

Rotors 1 and 4 stand opposite each other and turn alike, and so do 2 and 3. `spin` gives the sign of each rotor's
reaction torque on the body about +z: "+--+" where rotor 1 turns clockwise seen from above, "-++-" where it turns the
other way.
"""

from collections.abc import Callable, Mapping
from math import sqrt
from typing import NamedTuple

from plant.vectors import Rotors

SPINS: dict[str, Rotors] = {"+--+": Rotors(1.0, -1.0, -1.0, 1.0), "-++-": Rotors(-1.0, 1.0, 1.0, -1.0)}


class Positions(NamedTuple):
    """Rotor positions in body FLU [m]: x forward, y left."""

    x: Rotors
    y: Rotors


class Frame(NamedTuple):
    """Lengths of a frame in a file, and the rotor positions they give."""

    lengths: tuple[str, ...]
    positions: Callable[[Mapping[str, float]], Positions]


def _rectangle(fore_aft: float, side: float) -> Positions:
    return Positions(Rotors(fore_aft, fore_aft, -fore_aft, -fore_aft), Rotors(side, -side, side, -side))


def _x(lengths: Mapping[str, float]) -> Positions:
    lever = lengths["arm"] / sqrt(2.0)
    return _rectangle(lever, lever)


def _wide_x(lengths: Mapping[str, float]) -> Positions:
    return _rectangle(lengths["lever_fore_aft"], lengths["lever_side"])


def _plus(lengths: Mapping[str, float]) -> Positions:
    arm = lengths["arm"]
    return Positions(Rotors(arm, 0.0, 0.0, -arm), Rotors(0.0, -arm, arm, 0.0))


FRAMES: dict[str, Frame] = {
    "x": Frame(("arm",), _x),
    "plus": Frame(("arm",), _plus),
    "wide-x": Frame(("lever_fore_aft", "lever_side"), _wide_x),
}
