"""Options NAME=VALUE of commands."""

from plant.errors import InputError, shortened


def named_text(given: str, option: str, example: str, form: str = "NAME=VALUE") -> tuple[str, str]:
    """Return name and text of an option NAME=VALUE; InputError with an example for another form."""
    name, equals, text = (part.strip() for part in given.partition("="))
    if not (name and equals):
        raise InputError(f"given '{shortened(given)}'; write {form}, for instance {example}", key=option)
    return name, text


def named_number(given: str, option: str, example: str) -> tuple[str, float]:
    """Return name and number of an option NAME=VALUE."""
    name, text = named_text(given, option, example)
    try:
        return name, float(text)
    except ValueError:
        raise InputError(f"given '{shortened(given)}'; write a number, for instance {example}", key=option) from None
