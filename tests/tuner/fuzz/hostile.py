"""Hypothesis strategies of hostile files: a good table, changed in its structure, or its text, broken as text.

Everything is drawn from fixed pools, so that a derandomised run makes the same files on every machine.
"""

from copy import deepcopy
from math import inf, isfinite, nan

from hypothesis import strategies as st

from tests.tuner.fuzz.hostile_text import Nested

NUMBERS = (
    0, -1, 1, 2, 3, 7, 8, 0.0, -0.0, 0.5, 1.0, -1.0, 5e-324, 1e-308, 1e-12, 1e-3, 0.1, 90.0, 1e3, 1e6, 1e9, 1e30, 1e308, -1e308,
    inf, -inf, nan, 10**9, 2**31, 2**63 - 1, 2**63, 2**64, -(2**63), 10**40, 10**400,
)  # fmt: skip
TEXTS = (
    "", " ", ".", "..", "a\nb\r\nc", "\x00", "\x1b[31mred", "\x7f", "\u202egnp.exe", "\u2028", "e\u0301 🚁 漢字", "x" * 5000, "'\"\\",
    "../../../etc/passwd", "/etc/passwd", "/dev/zero", "/", "a.toml", "quickstart.toml", "[bold]x[/bold]", "[/]", "{x}", "{0!r}", "%s%n",
    "$\\frac{", "$x$ _^", "<script>alert(1)</script>", "</script>", "nan", "1e3", "true", "null", "=cmd()", "mean", "cvar", "worst",
    "hybrid", "pid", "ladrc", "hover", "level", "steps", "helix", "waypoints", "figure_eight", "ramp", "itae.position", "travel",
    "overshoot.x", "settling.position", "recovery.x", "min:travel", "weights", "closest", "sobol", "cmaes", "observer", "measured",
    "1797", "severe", "none", "linear", "log", "design", "x", "yaw", "tilt", "crazyflie-rotors", "paper-literal", "ultimate_error",
)  # fmt: skip
OTHERS = (
    True,
    False,
    [],
    {},
    [[]],
    [{}],
    [1.0],
    [0.0, 0.0, 0.0],
    [1.0, nan, 3.0],
    ["default"],
    [1, "a", True],
    {"low": 1.0},
)
FACTORS = (-1, 0, 1e-300, 1e-9, 0.1, 0.5, 0.9, 0.999, 1.001, 1.1, 2, 3, 10, 1000, 1e9, 1e300)
LEVELS = (1, 3, 30, 200, 50_000)


def places(table, path=()):
    """Yield the path of every value in nested tables and lists, inner ones too."""
    for key, value in table.items() if isinstance(table, dict) else enumerate(table):
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from places(value, (*path, key))


def at(table, path):
    for part in path:
        table = table[part]
    return table


@st.composite
def values(draw):
    """Draw a value of another type or of an extreme size."""
    pool = draw(st.sampled_from((NUMBERS, NUMBERS, TEXTS, OTHERS)))
    return deepcopy(draw(st.sampled_from(pool)))


def _misspelt(draw, text):
    i = draw(st.integers(0, max(len(text) - 1, 0)))
    return draw(
        st.sampled_from(
            (text[:i] + text[i + 1 :], text[:i] + "q" + text[i:], text.upper(), f"{text} ", f"{text}.{text}", "")
        )
    )


def _delete(draw, table, here, key, path):
    del here[key]


def _duplicate(draw, table, here, key, path):
    if isinstance(here, list):
        here.insert(key, deepcopy(here[key]))
    else:
        here[draw(st.sampled_from(("name", "low", "extra", "roll.k1", "attitude", f"{key} ")))] = deepcopy(here[key])


def _misspell(draw, table, here, key, path):
    if isinstance(here[key], str):
        here[key] = _misspelt(draw, here[key])
    elif isinstance(here, dict):
        here[_misspelt(draw, key)] = here.pop(key)


def _rename(draw, table, here, key, path):
    if isinstance(here, dict):
        here[draw(st.sampled_from(TEXTS))] = here.pop(key)


def _replace(draw, table, here, key, path):
    here[key] = draw(values())


def _extreme(draw, table, here, key, path):
    here[key] = draw(st.sampled_from(NUMBERS))


def _scale(draw, table, here, key, path):
    if isinstance(here[key], int | float) and not isinstance(here[key], bool):
        scaled = here[key] * draw(st.sampled_from(FACTORS))
        here[key] = int(scaled) if isinstance(here[key], int) and isfinite(scaled) else scaled


def _text(draw, table, here, key, path):
    here[key] = draw(st.sampled_from(TEXTS))


def _swap(draw, table, here, key, path):
    other = draw(st.sampled_from(list(places(table))))
    short = min(len(path), len(other))
    if path[:short] != other[:short]:
        there = at(table, other[:-1])
        here[key], there[other[-1]] = there[other[-1]], here[key]


def _insert(draw, table, here, key, path):
    if isinstance(here, list):
        here.append(draw(values()))
    else:
        here[
            draw(
                st.sampled_from(
                    ("name", "file", "path", "scale", "tie", "window", "level", "axis", "x", "[bold]", "a\nb")
                )
            )
        ] = draw(values())


def _empty(draw, table, here, key, path):
    here[key] = draw(st.sampled_from(([], {}, "", 0)))


def _nest(draw, table, here, key, path):
    here[key] = Nested(draw(st.sampled_from(LEVELS)))


CHANGES = (
    _delete,
    _duplicate,
    _misspell,
    _rename,
    _replace,
    _extreme,
    _scale,
    _scale,
    _text,
    _swap,
    _insert,
    _empty,
    _nest,
)


@st.composite
def mutated(draw, table):
    """Draw a table with one to three changes, each at any place of it."""
    result = deepcopy(table)
    for _ in range(draw(st.sampled_from((1, 1, 1, 2, 3)))):
        found = list(places(result))
        if not found:
            break
        # Any level with equal chance: else the many leaves would hide the tables.
        depth = draw(st.sampled_from(sorted({len(path) for path in found})))
        path = draw(st.sampled_from([path for path in found if len(path) == depth]))
        if depth > 8:
            break
        draw(st.sampled_from(CHANGES))(draw, result, at(result, path[:-1]), path[-1], path)
    return result


@st.composite
def shaken(draw, table):
    """Draw a table with one to four numbers or texts changed, often into something that may still be read."""
    result = deepcopy(table)
    for _ in range(draw(st.sampled_from((1, 1, 2, 3)))):
        leaves = [path for path in places(result) if not isinstance(at(result, path), dict | list)]
        path = draw(st.sampled_from(leaves))
        here, key = at(result, path[:-1]), path[-1]
        change = _text if isinstance(here[key], str) else draw(st.sampled_from((_scale, _scale, _scale, _extreme)))
        change(draw, result, here, key, path)
    return result


@st.composite
def broken(draw, content):
    """Draw bytes with a part cut off, doubled or overwritten."""
    first = draw(st.integers(0, len(content) - 1))
    last = min(first + draw(st.sampled_from((1, 2, 10, 200))), len(content))
    junk = draw(
        st.sampled_from(
            (
                b"",
                b"\x00",
                b"\xff\xfe",
                b"=",
                b'"',
                b"[",
                b"]",
                b"{",
                b"\n",
                b"'''",
                b"[[",
                b"#",
                b"\xef\xbb\xbf",
                b"9" * 5000,
            )
        )
    )
    return draw(
        st.sampled_from(
            (
                content[:first],
                content[first:],
                content[:first] + junk + content[last:],
                content[:last] + content[first:],
            )
        )
    )
