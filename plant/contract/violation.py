"""Places where something of the user's own breaks its contract: in words, with file and line."""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from plant.errors import InputError
from plant.model.functions import place_of
from plant.own_code import place_of_error


class ContractViolation(NamedTuple):
    """A promise that is not kept. part: the function or record that breaks it, such as "step"; place: "file:line"."""

    part: str
    message: str
    place: str = ""

    @property
    def error(self) -> InputError:
        """The same as an error."""
        return InputError(self.message, file=self.place or None, key=self.part)


def violations_of(check: Callable[[], Iterator[ContractViolation]], owner: Any, file: str) -> list[ContractViolation]:
    """Return the breaches of a check, each once and with its place; an error inside it is one of them.

    owner: has the parts as attributes.
    """
    violations: list[ContractViolation] = []
    try:
        violations += check()
    except InputError as error:
        return [
            *_placed(violations, owner, file),
            ContractViolation(error.key or "", error.message, error.file or file),
        ]
    except Exception as error:
        place = place_of_error(error)
        if place is None:
            raise
        violations.append(ContractViolation("", f"{type(error).__name__}: {error}", place))
    return _placed(violations, owner, file)


def _placed(violations: list[ContractViolation], owner: Any, file: str) -> list[ContractViolation]:
    return [
        violation._replace(
            place=violation.place or place_of(getattr(owner, violation.part.partition(".")[0], None), file)
        )
        for violation in dict.fromkeys(violations)
    ]
