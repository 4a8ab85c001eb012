"""Identification: objective, problem, recorder, optimiser, native solver, uncertainty."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .fitted import Fit as Fit
    from .fitting import identify as identify
    from .held_material import intervals_beside_material as intervals_beside_material
    from .held_material import is_passive as is_passive
    from .held_material import within_material as within_material
    from .intervals import bootstrap as bootstrap
    from .intervals import fit_batch as fit_batch
    from .intervals import held_costs as held_costs
    from .intervals import profile as profile
    from .leastsquares import levenberg_marquardt as levenberg_marquardt
    from .material_fit import least_error as least_error
    from .native import (
        BoundedDescent as BoundedDescent,
    )
    from .native import (
        Effort as Effort,
    )
    from .native import (
        fit as fit,
    )
    from .native import (
        minima_in_box as minima_in_box,
    )
    from .native import (
        scanned_starts as scanned_starts,
    )
    from .prediction import Prediction as Prediction
    from .problem import (
        Objective as Objective,
    )
    from .problem import (
        Problem as Problem,
    )
    from .problem import (
        Searched as Searched,
    )
    from .problem import (
        SpecimenProblem as SpecimenProblem,
    )
    from .problem import (
        default_objective as default_objective,
    )
    from .problem import (
        weighted as weighted,
    )
    from .recorder import (
        BudgetSpent as BudgetSpent,
    )
    from .recorder import (
        Recorder as Recorder,
    )
    from .recorder import (
        RecorderGroup as RecorderGroup,
    )
    from .recorder import (
        all_points as all_points,
    )
    from .regularisation import regularised as regularised
    from .result import Identification as Identification
    from .runs import AskingOptimiser as AskingOptimiser
    from .runs import (
        BatchedOptimiser as BatchedOptimiser,
    )
    from .runs import (
        Card as Card,
    )
    from .runs import Enquiry as Enquiry
    from .runs import (
        Optimiser as Optimiser,
    )
    from .runs import (
        OptimiserFamily as OptimiserFamily,
    )
    from .runs import (
        run as run,
    )
    from .runs import (
        run_batch as run_batch,
    )
    from .space import SearchSpace as SearchSpace
    from .starts import Window as Window
    from .starts import settings as settings
    from .starts import shown as shown
    from .uncertainty import (
        Uncertainty as Uncertainty,
    )
    from .value import Value as Value

__getattr__, __dir__ = offered(
    __name__,
    {
        "fitting": "identify",
        "held_material": "intervals_beside_material is_passive within_material",
        "leastsquares": "levenberg_marquardt",
        "material_fit": "least_error",
        "fitted": "Fit",
        "native": "BoundedDescent Effort fit minima_in_box scanned_starts",
        "prediction": "Prediction",
        "intervals": "bootstrap fit_batch held_costs profile",
        "problem": "default_objective Objective Problem Searched SpecimenProblem weighted",
        "recorder": "all_points BudgetSpent Recorder RecorderGroup",
        "regularisation": "regularised",
        "result": "Identification",
        "runs": (
            "AskingOptimiser BatchedOptimiser Card Enquiry Optimiser OptimiserFamily run run_batch"
        ),
        "space": "SearchSpace",
        "starts": "settings shown Window",
        "uncertainty": "Uncertainty",
        "value": "Value",
    },
)
