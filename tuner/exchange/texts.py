"""Texts inside the languages that exports are written in: one function for each place where a text can stand, and templates.

The border refuses what no name and no title holds (`plant.texts`), yet every text from a file goes through one of these all the
same: whatever it is, it stays a comment or a string and is never code. Characters that do not print come out as their escapes.
A comment that ends with its line, as in YAML and MATLAB, takes a text as `plant.errors.one_line` returns it.
"""

import re
from collections.abc import Callable
from functools import cache
from html import escape
from importlib.resources import files

from plant.errors import one_line, shortened
from tuner.exchange.target import Request
from tuner.text.version import version

# Characters of a C string that mean themselves; a question mark may begin a trigraph.
_PLAIN_IN_C = frozenset("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789 !#$%&'()*+,-./:;<=>@[]^_`{|}~")
# Letters of a comment in a parameter file: Betaflight's command line holds 256 to a line.
LONGEST_COMMENT = 160
TOOL = "gainproof"
WRITTEN_BY = f"Written by {TOOL}"
"""Beginning of the heading of an export, by which it is recognized."""


def c_comment(text: str) -> str:
    """Return a text for the inside of a C comment; it can neither end nor begin one."""
    return re.sub(r"\*(?=/)|/(?=\*)|\?(?=\?)", r"\g<0> ", one_line(text))


def c_string(text: str) -> str:
    """Return a text as a C string literal of ASCII, quotes included; other letters are their UTF-8 bytes in octal."""
    letters = (
        letter if letter in _PLAIN_IN_C else "".join(f"\\{byte:03o}" for byte in letter.encode())
        for letter in one_line(text)
    )
    return f'"{"".join(letters)}"'


def python_docstring(text: str) -> str:
    """Return a text for a Python docstring, which it cannot end."""
    return one_line(text).replace("\\", "\\\\").replace('"', '\\"')


def matlab_string(text: str) -> str:
    """Return a text as character vector of MATLAB and Octave, with quotes."""
    return "'" + one_line(text).replace("'", "''") + "'"


def parameter_comment(text: str) -> str:
    """Return a text for a comment line after # and a blank.

    Such comments stand in a parameter file or on a command line. Betaflight's command line takes a question mark for a
    request to complete the line.
    """
    return shortened(one_line(text).replace("?", "."), LONGEST_COMMENT)


def xml_text(text: str) -> str:
    """Return a text for an XML or HTML element, or an attribute (in double quotes)."""
    return escape(one_line(text))


def markdown(text: str) -> str:
    """Return a text for Markdown, without links, HTML or emphasis; for a paragraph or a table cell."""
    return re.sub(r"[\\`*_{}\[\]<>|&~$!#]", r"\\\g<0>", one_line(text))


def tool() -> str:
    """Return the name and version of the tool that writes an export."""
    return f"{TOOL} {version()}"


def heading(request: Request, write: Callable[[str], str]) -> tuple[str, str, str]:
    """Return three lines: tool and digest of the gains, airframe, laws with their control period.

    write: the function of `tuner.exchange.texts` for the place where the lines are to stand.
    """
    controller = request.controller
    return (
        write(f"Written by {tool()} from the gains {request.digest}"),
        write(f"Airframe: {controller.airframe.name} ({controller.airframe.title})"),
        write(
            f"Laws: position {controller.cascade.position.name}, attitude {controller.cascade.attitude.name}; "
            f"control period {controller.control_period:.10g} s"
        ),
    )


def filled(target: str, name: str, **values: object) -> str:
    """Return a target's template with every @WORD@ in it replaced.

    All at once, so that nothing inside a value is replaced. target: package of the target; name: of the file that is
    written, whose template is templates/NAME.in there.
    """
    return re.sub(r"@(\w+)@", lambda word: str(values[word[1]]), _template(target, name))


@cache
def _template(target: str, name: str) -> str:
    return files(target).joinpath("templates", f"{name}.in").read_text(encoding="utf-8")
