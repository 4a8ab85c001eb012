"""Identification: objective, problem, recorder, optimiser, native solver, uncertainty."""

from .batch import fit_batch
from .bounded import BoundedDescent, minima_in_box
from .held_material import intervals_beside_material
from .identify import best_run, identify
from .leastsquares import Solution, levenberg_marquardt
from .ledger import BudgetSpent, all_points
from .material import is_material, own_parameters
from .material_fit import least_error
from .native import Effort, Fit, fit, scanned_starts
from .objective import Objective, default_objective, weighted
from .optimiser import BatchedOptimiser, Card, Optimiser, OptimiserFamily
from .passive import is_passive, within_material
from .prediction import Prediction
from .problem import Problem, Searched
from .recorder import Recorder, RecorderGroup
from .regularised import Spectrum, regularised
from .result import Identification, Standing
from .run import Run, run, run_batch
from .settings import EDGE, Window, settings, shown
from .simulated import bootstrap
from .space import SearchSpace, box_of, paper_box, require_conditions
from .uncertainty import Uncertainty, held_costs, profile
from .value import Value, kept_interval

__all__ = [
    "BatchedOptimiser",
    "BoundedDescent",
    "BudgetSpent",
    "Card",
    "EDGE",
    "Effort",
    "Fit",
    "Identification",
    "Objective",
    "Optimiser",
    "OptimiserFamily",
    "Prediction",
    "Problem",
    "Recorder",
    "RecorderGroup",
    "Run",
    "SearchSpace",
    "Searched",
    "Solution",
    "Spectrum",
    "Standing",
    "Uncertainty",
    "Value",
    "Window",
    "all_points",
    "best_run",
    "bootstrap",
    "box_of",
    "default_objective",
    "fit",
    "fit_batch",
    "identify",
    "intervals_beside_material",
    "is_material",
    "is_passive",
    "kept_interval",
    "own_parameters",
    "least_error",
    "levenberg_marquardt",
    "minima_in_box",
    "paper_box",
    "held_costs",
    "profile",
    "regularised",
    "require_conditions",
    "run",
    "run_batch",
    "scanned_starts",
    "settings",
    "shown",
    "weighted",
    "within_material",
]
