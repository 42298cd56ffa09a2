"""Keys of every study on what an interval decides: its confidence, and the share from which a difference matters."""

from typing import Annotated

from pydantic import Field

Confidence = Annotated[float, Field(ge=0.0, lt=1.0)]
CONFIDENCE = 0.95
"""Confidence that limits on flights are kept with where a study does not say it: that of every interval that is shown."""
Relevant = Annotated[float, Field(ge=0.0, lt=1.0)]
