"""Messages of the page, checked: a setting with its pins, a scenario and a loop."""

from dataclasses import dataclass
from math import isfinite
from typing import Any

from plant.errors import InputError, check_name, one_line, shortened
from tuner.extensions.studio.session import MAX_PINS, Session, Setting

MAX_NAME = 40
"""Letters of a pin's name."""
MAX_NUMBER = 2**53
"""Largest number of a request."""


@dataclass(frozen=True, eq=False)
class PageRequest:
    """A request of the page.

    Attributes:
        number: Number of the request; a larger one of the same page overtakes it.
        page: Name of the page that sent it.
        settings: The setting at hand, then default, tuned and pins.
        scenario: Number of the scenario whose responses are drawn.
        channel: Name of the loop that is drawn, "" for none.
    """

    number: int
    page: str
    settings: tuple[Setting, ...]
    scenario: int
    channel: str


def read_request(session: Session, channels: list[str], message: Any) -> PageRequest:
    """Return a message as a request; InputError for a key that is wrong.

    Args:
        session: The opened study.
        channels: Names of the loops.
        message: Content of the message, from JSON.
    """
    content = table_of(message, "message")
    setting = Setting("here", session.row(values_of(content.get("values", {}))), "here")
    scenario = whole_number(content.get("scenario", 0), len(session.study.scenarios) - 1, "scenario")
    channel = content.get("channel") or (channels[0] if channels else "")
    if channels:
        check_name("loop", text_of(channel, "channel"), channels, key="channel")
    return PageRequest(
        whole_number(content.get("number", 0), MAX_NUMBER, "number"),
        text_of(content.get("page", ""), "page"),
        (setting, *session.fixed, *_pins(session, content.get("pins", []))),
        scenario,
        channel if channels else "",
    )


def _pins(session: Session, given: Any) -> list[Setting]:
    if not isinstance(given, list) or len(given) > MAX_PINS:
        raise InputError(f"allowed: a list of at most {MAX_PINS} pins; remove one first", key="pins")
    pins = []
    for i, entry in enumerate(given):
        pin = table_of(entry, f"pins.{i}")
        name = text_of(pin.get("name", ""), f"pins.{i}.name").strip() or f"pin {i + 1}"
        pins.append(Setting(name, session.row(values_of(pin.get("values", {}))), f"pin{i + 1}"))
    return pins


def table_of(content: Any, key: str) -> dict[str, Any]:
    """Return content that is a table; InputError for other content."""
    if not isinstance(content, dict):
        raise InputError(f"given a {type(content).__name__}; allowed: a table of names and values", key=key)
    return content


def values_of(content: Any) -> dict[str, float]:
    """Return numbers by name; InputError for other content."""
    values = dict[str, float]()
    for name, value in table_of(content, "values").items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(float(value)):
            raise InputError("allowed: a finite number", key=shortened(str(name)))
        values[str(name)] = float(value)
    return values


def whole_number(content: Any, most: int, key: str) -> int:
    """Return a whole number from 0 on; InputError for other content."""
    if isinstance(content, bool) or not isinstance(content, int) or not 0 <= content <= most:
        raise InputError(f"allowed: a whole number from 0 to {most}", key=key)
    return content


def text_of(content: Any, key: str, most: int = MAX_NAME) -> str:
    """Return a text of one line; InputError for other content or a long one."""
    if not isinstance(content, str) or len(content) > most:
        raise InputError(f"allowed: a text of at most {most} letters", key=key)
    return one_line(content)
