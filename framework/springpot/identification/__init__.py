"""Identification: objective, problem, recorder, optimiser, native solver, uncertainty."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .batch import fit_batch
    from .fitting import best_run, identify, searched
    from .held_material import intervals_beside_material
    from .leastsquares import Solution, levenberg_marquardt
    from .material import is_material, own_parameters
    from .material_fit import least_error
    from .native import BoundedDescent, Effort, Fit, fit, minima_in_box, scanned_starts
    from .passive import is_passive, within_material
    from .prediction import Known, Prediction
    from .problem import Objective, Problem, Searched, default_objective, weighted
    from .ranges import EDGE, Window, settings, shown
    from .recorder import BudgetSpent, Recorder, RecorderGroup, all_points
    from .regularisation import SmoothSpectrum, regularised
    from .result import Identification, Standing
    from .runs import BatchedOptimiser, Card, Optimiser, OptimiserFamily, Run, run, run_batch
    from .simulated import bootstrap
    from .space import SearchSpace, box_of, paper_box, require_conditions
    from .uncertainty import Uncertainty, held_costs, profile
    from .value import Value

__all__ = [
    "BatchedOptimiser",
    "BoundedDescent",
    "BudgetSpent",
    "Card",
    "EDGE",
    "Effort",
    "Fit",
    "Identification",
    "Known",
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
    "SmoothSpectrum",
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
    "searched",
    "settings",
    "shown",
    "weighted",
    "within_material",
]

_WHERE = {
    "BatchedOptimiser": "springpot.identification.runs",
    "BoundedDescent": "springpot.identification.native",
    "BudgetSpent": "springpot.identification.recorder",
    "Card": "springpot.identification.runs",
    "EDGE": "springpot.identification.ranges",
    "Effort": "springpot.identification.native",
    "Fit": "springpot.identification.native",
    "Identification": "springpot.identification.result",
    "Known": "springpot.identification.prediction",
    "Objective": "springpot.identification.problem",
    "Optimiser": "springpot.identification.runs",
    "OptimiserFamily": "springpot.identification.runs",
    "Prediction": "springpot.identification.prediction",
    "Problem": "springpot.identification.problem",
    "Recorder": "springpot.identification.recorder",
    "RecorderGroup": "springpot.identification.recorder",
    "Run": "springpot.identification.runs",
    "SearchSpace": "springpot.identification.space",
    "Searched": "springpot.identification.problem",
    "Solution": "springpot.identification.leastsquares",
    "SmoothSpectrum": "springpot.identification.regularisation",
    "Standing": "springpot.identification.result",
    "Uncertainty": "springpot.identification.uncertainty",
    "Value": "springpot.identification.value",
    "Window": "springpot.identification.ranges",
    "all_points": "springpot.identification.recorder",
    "best_run": "springpot.identification.fitting",
    "bootstrap": "springpot.identification.simulated",
    "box_of": "springpot.identification.space",
    "default_objective": "springpot.identification.problem",
    "fit": "springpot.identification.native",
    "fit_batch": "springpot.identification.batch",
    "held_costs": "springpot.identification.uncertainty",
    "identify": "springpot.identification.fitting",
    "intervals_beside_material": "springpot.identification.held_material",
    "is_material": "springpot.identification.material",
    "is_passive": "springpot.identification.passive",
    "least_error": "springpot.identification.material_fit",
    "levenberg_marquardt": "springpot.identification.leastsquares",
    "minima_in_box": "springpot.identification.native",
    "own_parameters": "springpot.identification.material",
    "paper_box": "springpot.identification.space",
    "profile": "springpot.identification.uncertainty",
    "regularised": "springpot.identification.regularisation",
    "require_conditions": "springpot.identification.space",
    "run": "springpot.identification.runs",
    "run_batch": "springpot.identification.runs",
    "scanned_starts": "springpot.identification.native",
    "searched": "springpot.identification.fitting",
    "settings": "springpot.identification.ranges",
    "shown": "springpot.identification.ranges",
    "weighted": "springpot.identification.problem",
    "within_material": "springpot.identification.passive",
}

__getattr__, __dir__ = offered(__name__, _WHERE)
