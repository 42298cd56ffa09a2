"""The searches that a study can ask for, by the names of `tuner.search.names`."""

from tuner.search.nsga2 import Nsga2

SEARCHES = {"nsga2": Nsga2}
