"""Types of the public names, for checkers alone: at run time a name is imported when it is first used."""

from plant.errors import InputError as InputError
from plant.errors import StoreError as StoreError
from plant.errors import ToolError as ToolError
from plant.errors import UnknownNameError as UnknownNameError
from tuner.api.catalogue import catalogue as catalogue
from tuner.api.checking import check as check
from tuner.api.checking import check_requirements as check_requirements
from tuner.api.checking import validate as validate
from tuner.api.comparing import compare as compare
from tuner.api.designing import design as design
from tuner.api.exporting import export as export
from tuner.api.exporting import import_gains as import_gains
from tuner.api.flying import fly as fly
from tuner.api.gains import Gains as Gains
from tuner.api.gains import default_gains as default_gains
from tuner.api.gains import read_gains as read_gains
from tuner.api.margins import margins as margins
from tuner.api.planning import plan as plan
from tuner.api.results import ComparisonResults as ComparisonResults
from tuner.api.results import Results as Results
from tuner.api.results import TuningResults as TuningResults
from tuner.api.results import open_results as open_results
from tuner.api.results import read_table as read_table
from tuner.api.runs import rejudge as rejudge
from tuner.api.runs import resume as resume
from tuner.api.runs import run as run
from tuner.api.runs import verify as verify
from tuner.api.studies import PlantStudy as PlantStudy
from tuner.api.studies import Study as Study
from tuner.api.studies import load_study as load_study
from tuner.api.studies import make_study as make_study
from tuner.extensions.autotune.api import autotune as autotune
from tuner.extensions.betaflight_adrc.api import adrc as adrc
from tuner.extensions.contests.results import ContestResults as ContestResults
from tuner.extensions.first_flights.approach_api import approach as approach
from tuner.extensions.first_flights.confirmation_api import confirm as confirm
from tuner.extensions.flight_plans.api import plan_flight as plan_flight
from tuner.extensions.identification.api import check_logs as check_logs
from tuner.extensions.identification.api import identify as identify
from tuner.extensions.judge.api import judge as judge
from tuner.extensions.judge.api import read_back as read_back
from tuner.extensions.log_comparison.api import compare_logs as compare_logs
from tuner.extensions.notebook.studio import studio as studio
from tuner.extensions.parts_list.api import estimate_airframe as estimate_airframe
from tuner.extensions.phase_plane.api import phase_plane as phase_plane
from tuner.extensions.plant_fit.api import fit as fit
from tuner.extensions.processor_cost.api import cost as cost
from tuner.extensions.sensitivity.api import sensitivity as sensitivity
from tuner.extensions.tails.api import tail as tail
from tuner.extensions.theory.api import theory as theory
from tuner.extensions.trials.api import ask as ask
from tuner.extensions.trials.api import tell as tell
from tuner.search.watcher import Watcher as Watcher
from tuner.study.own_code import use as use

__all__: list[str]
__version__: str
_HOMES: dict[str, tuple[str, ...]]
