"""Parts of summary.json on limits.

Limits that no candidate satisfied, their causes, and the cost of the others.
"""

from pydantic import Field

from tuner.store.document import DocumentPart, Sense


class RelaxedLimit(DocumentPart):
    """A limit that has to give way, and where to."""

    label: str
    unit: str
    shown_unit: str | None = None
    sense: Sense
    limit: float
    relaxed: float


class RelaxationRow(DocumentPart):
    """The least step of limits that lets a candidate in; share: of each limit; default: the candidate is the default itself."""

    candidate: str
    default: bool = False
    share: float
    limits: list[RelaxedLimit]


class ConflictPart(DocumentPart):
    """Limits that no candidate satisfied together. sets: the smallest; single: steps of one limit; common: of all limits
    alike.
    """

    sets: list[list[str]]
    single: list[RelaxationRow]
    common: RelaxationRow | None


class GainAt(DocumentPart):
    """A gain at a value."""

    gain: str
    value: float
    unit: str


class DesignReach(DocumentPart):
    """Reach of a design: the value (null: no bound), whether it satisfies the limit, and the gains of the loop.

    in_ranges: whether it keeps the limit with the searched gains alone, so that a search can start there.
    """

    value: float | None
    is_satisfied: bool = Field(alias="kept")
    in_ranges: bool = False
    gains: list[GainAt]


class UnmetConstraint(DocumentPart):
    """Cause of a limit that no candidate satisfies.

    loop: axis that breaks it, null where it is no margin of one loop; reached: best value (null: infinite), by point; tried:
    candidates looked at; moved_by: searched gains that bring it nearer; fixed: gains that do and are not searched; automatic: key
    that moves the limit, "" where the study writes it.
    """

    label: str
    loop: str | None
    unit: str
    shown_unit: str | None = None
    sense: Sense
    limit: float
    reached: float | None
    point: str
    tried: int
    moved_by: list[str]
    fixed: list[GainAt] = []
    design: DesignReach | None = None
    automatic: str = ""


class ConstraintPrice(DocumentPart):
    """The best value of an objective over the feasible candidates, with a limit and without it."""

    limit: str
    objective: str
    unit: str
    with_limit: float = Field(alias="with")
    without: float
