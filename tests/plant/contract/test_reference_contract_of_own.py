"""What a reference of one's own breaks is told, with the line of its class or of track."""

from pathlib import Path

import pytest

from plant.contract.reference_contract import violations_of_reference
from plant.own_code import run_own_code
from plant.references import REFERENCES
from plant.references.waypoints import Waypoints
from tests.plant.own_files import REFERENCE, edited

WRONG = {
    "moves at once": ("pace = turn * 0.5 * (1.0 - np.cos(pi * ramp))", "pace = turn + 0.0 * ramp", "moves at t = 0"),
    "other rate": ("self.radius * pace[:, None] * onward", "2.0 * self.radius * pace[:, None] * onward", "not the rate"),
    "nan": ("turn, ramp = 2.0 * pi / self.period", "turn, ramp = float('nan')", "not finite at t = 0"),
    "shape": ("samples = blank(t.size)", "samples = blank(t.size)[:, :13]", "it must be"),
    "no unit": ('number("m", "radius of the circle", default=1.0, above=0.0)', "1.0", "has no unit"),
    "no name": ('kind: ClassVar[str] = "circle"', 'kind: ClassVar[str] = "My Circle"', "has no name"),
    "no track": ("return without_step(samples)", "return samples", "must give Track"),
    "no class": ("REFERENCE = Circle", "REFERENCE = 3", "must be a class of ReferenceSpec"),
}  # fmt: skip


def test_the_shipped_and_the_bundled_ones_keep_it() -> None:
    kinds = [
        run_own_code(REFERENCE).names["REFERENCE"],
        *[kind for kind in REFERENCES.values() if kind is not Waypoints],
    ]
    # A step of nothing is refused by itself: it has no usual parameters.
    assert [violations_of_reference(kind, "") for kind in kinds if kind.kind not in ("steps", "ramp")] == [
        [] for _ in kinds[2:]
    ]


@pytest.mark.parametrize("way", WRONG)
def test_what_it_breaks_is_told(way: str, tmp_path: Path) -> None:
    old, new, message = WRONG[way]
    file = edited(REFERENCE, tmp_path, (old, new))
    told = violations_of_reference(run_own_code(file).names["REFERENCE"], str(file))
    assert any(message in violation.message for violation in told), told
    assert all(violation.place.startswith(str(file)) for violation in told)
