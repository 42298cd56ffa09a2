"""gains.json of a study whose trials another program makes: the values of its variables at one point."""

from typing import Annotated, Literal

from tuner.documents.parts import GainValue
from tuner.store.document import Document
from tuner.text.product import READ_FORMER


class VariablesDocument(Document):
    """Content of gains.json where variables are those of another program.

    study, title, digest: of the study; point: by name, the recommended one or, where feasible is false, the nearest to it; gains:
    value and unit of each variable.
    """

    format: Annotated[Literal["gainproof-variables"], READ_FORMER]
    version: Literal[1]
    study: str
    title: str
    digest: str
    point: str
    feasible: bool
    gains: dict[str, GainValue]
