"""Content hash of gains.json, and the comparison of two documents.

The hash is SHA-256 over the canonical form, RFC 8785, "JSON Canonicalization Scheme": keys sorted by UTF-16 code units, numbers
as ECMAScript writes doubles, UTF-8, no blanks. So the hash does not depend on the order of keys, on indentation, or on who
writes 0.10 for 0.1.
"""

import hashlib
from typing import Any

from plant.errors import InputError
from tuner.gains.sections import MAX_EXACT_INTEGER, VERSION, Row

# What may be added later without another controller coming of it.
OUTSIDE = ("sha256", "exports", "cost")


def content_hash(document: Row) -> str:
    """Return the hash (64 hex digits) of everything in a gains document but `OUTSIDE`."""
    return canonical_hash({key: value for key, value in document.items() if key not in OUTSIDE})


def canonical_hash(value: Any) -> str:
    """Return the SHA-256 over the canonical form; raises InputError where there is none."""
    return hashlib.sha256(canonical(value)).hexdigest()


def canonical(value: Any) -> bytes:
    """Return the canonical form; raises InputError for numbers that are not finite and texts that are no Unicode."""
    import rfc8785

    try:
        return rfc8785.dumps(_doubles(value))
    except (rfc8785.CanonicalizationError, UnicodeError) as error:
        raise InputError(f"has no canonical form ({error}); take out what is no number or no Unicode text") from None


def _doubles(value: Any) -> Any:
    """Return the same value with large integers as doubles.

    Every other reader of JSON makes these doubles of them.
    """
    if isinstance(value, dict):
        return {key: _doubles(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_doubles(inner) for inner in value]
    if isinstance(value, int) and not isinstance(value, bool) and abs(value) > MAX_EXACT_INTEGER:
        return float(value)
    return value


# Margins come from linear algebra whose last bits differ from machine to machine.
ASIDE = (*OUTSIDE, "generator", "margins")


def same_result(recorded: Row, made: Row) -> bool:
    """Return True if a recorded document agrees with `made`; it may be older or damaged."""
    try:
        if recorded["version"] != VERSION:
            return _values(recorded) == _values(made)
        digest = made["sha256"]
        if recorded.get("sha256", digest) not in (content_hash(recorded), digest):
            return False
        return _compared_content(recorded) == _compared_content(made)
    except (KeyError, TypeError, AttributeError, ValueError):
        return False


def _compared_content(document: Row) -> Row:
    return {key: value for key, value in document.items() if key not in ASIDE}


def _values(document: Row) -> Row:
    return {address: gain["value"] for address, gain in document["gains"].items()}
