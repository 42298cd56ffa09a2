"""Do two gains documents come from the same result? What wrote them, and what was added later, does not count."""

from tuner.gains.hashing import OUTSIDE, content_hash
from tuner.gains.sections import VERSION
from tuner.gains.shapes import Row

# Margins come from linear algebra whose last bits differ from machine to machine.
ASIDE = (*OUTSIDE, "generator", "margins")


def same_result(recorded: Row, made: Row) -> bool:
    """Return whether a recorded document, which may be of an older version or damaged, tells what `made` tells."""
    try:
        if recorded["version"] != VERSION:
            return _values(recorded) == _values(made)
        if recorded.get("sha256", made["sha256"]) not in (content_hash(recorded), made["sha256"]):
            return False
        return _told(recorded) == _told(made)
    except (KeyError, TypeError, AttributeError, ValueError):
        return False


def _told(document: Row) -> Row:
    return {key: value for key, value in document.items() if key not in ASIDE}


def _values(document: Row) -> Row:
    return {address: gain["value"] for address, gain in document["gains"].items()}
