"""Gains of several axes told as one where they are the same: most studies set all axes of a loop alike."""

from tuner.documents.contest import Gain

# Names that stand for several axes in an address, the larger ones first.
GROUPS = (
    ("position", ("x", "y", "z")),
    ("attitude", ("roll", "pitch", "yaw")),
    ("horizontal", ("x", "y")),
    ("tilt", ("roll", "pitch")),
)


def joined(gains: list[Gain]) -> list[Gain]:
    """Return gains in their order, those of a whole group of axes as one where all have the same value."""
    told = list(gains)
    for group, axes in GROUPS:
        for name in dict.fromkeys(gain.address.partition(".")[2] for gain in gains):
            members = [gain for gain in told if gain.address in [f"{axis}.{name}" for axis in axes]]
            if len(members) == len(axes) and len({gain.value for gain in members}) == 1:
                told[told.index(members[0])] = members[0]._replace(address=f"{group}.{name}")
                told = [gain for gain in told if gain not in members]
    return told
