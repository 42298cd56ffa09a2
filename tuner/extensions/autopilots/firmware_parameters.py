"""Parameters of an exported file, without those of position loops."""

from re import Pattern

from plant.errors import InputError, shortened


def parameters_in(
    content: bytes, entry: Pattern[str], heading: Pattern[str], position: tuple[str, ...]
) -> dict[str, float]:
    """Return the parameters of a file but those of the position loops; raises InputError naming another line.

    Args:
        content: Content of the file.
        entry: A line with a parameter: its name and its value.
        heading: Beginning of a line without one.
        position: Beginnings of the names of the position loops' parameters.
    """
    parameters: dict[str, float] = {}
    for line in content.decode("ascii").splitlines():
        match = entry.fullmatch(line)
        if match is None and heading.match(line) is None:
            raise InputError(f"the exported file has the line '{shortened(line)}', which stores no parameter")
        if match is not None and not match[1].startswith(position):
            parameters[match[1]] = float(match[2])
    return parameters
