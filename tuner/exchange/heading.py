"""What every text file of an export says of itself: the tool, the gains it comes from, what they are for."""

from collections.abc import Callable

from tuner.exchange.exporter import Request
from tuner.text.version import version


def tool() -> str:
    """Return the name and version of the tool that writes an export."""
    return f"holdfast {version()}"


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
