"""Study files, read and checked."""

from tuner.study.build import load_study
from tuner.study.study import Study

__all__ = ["Study", "load_study"]
