"""What every text file of an export says of itself: the tool, the gains it comes from, what they are for."""

from tuner.export.exporter import Request


def heading(request: Request) -> tuple[str, str, str]:
    """Return three lines: tool and digest of the gains, airframe, laws with their control period."""
    controller = request.controller
    return (
        f"Written by holdfast from the gains {request.digest}",
        f"Airframe: {controller.airframe.name} ({controller.airframe.title})",
        f"Laws: position {controller.cascade.position.name}, attitude {controller.cascade.attitude.name}; "
        f"control period {controller.control_period:.10g} s",
    )
