"""What a target that holds a whole controller goes back to: the previous gains.json, or the default gains of the laws."""

from dataclasses import replace

from plant.gains import default_row
from tuner.exchange.exporter import Request
from tuner.gains import Controller, content_hash, content_sha256, read_gains, to_document


def previous_controller(request: Request) -> tuple[Controller, str, str]:
    """Return the controller to go back to, the digest that its file names, and one sentence that says what it is.

    Raises InputError where the previous file is no gains.json.
    """
    controller = request.controller
    if request.previous is not None:
        return read_gains(request.previous), content_sha256(request.previous), "The gains flown before this export."
    defaults = replace(controller, gains=tuple(default_row(controller.cascade)))
    sentence = "The default gains of these laws: no gains.json with the previous ones was given."
    return defaults, content_hash(to_document(defaults, {})), sentence


def rollback_request(request: Request) -> tuple[Request, str]:
    """Return the request that would have exported the controller to go back to, and the sentence that says what it is."""
    controller, digest, sentence = previous_controller(request)
    return replace(request, controller=controller, digest=digest, previous=None), sentence
