"""Identification: objective, problem, recorder, optimiser, native solver, uncertainty."""

from __future__ import annotations

from typing import TYPE_CHECKING

from springpot.lazy import offered

if TYPE_CHECKING:
    from .convex import (
        is_passive as is_passive,
        least_error as least_error,
        within_material as within_material,
    )
    from .fitting import identify as identify
    from .held_material import intervals_beside_material as intervals_beside_material
    from .intervals import (
        bootstrap as bootstrap,
        fit_batch as fit_batch,
        held_costs as held_costs,
        profile as profile,
    )
    from .leastsquares import Effort as Effort, levenberg_marquardt as levenberg_marquardt
    from .native import (
        BoundedDescent as BoundedDescent,
        Fit as Fit,
        fit as fit,
        minima_in_box as minima_in_box,
        scanned_starts as scanned_starts,
    )
    from .prediction import Prediction as Prediction
    from .problem import (
        Objective as Objective,
        Problem as Problem,
        Searched as Searched,
        SpecimenProblem as SpecimenProblem,
        default_objective as default_objective,
        weighted as weighted,
    )
    from .recorder import (
        BudgetSpent as BudgetSpent,
        Recorder as Recorder,
        RecorderGroup as RecorderGroup,
        all_points as all_points,
    )
    from .regularisation import regularised as regularised
    from .result import Identification as Identification
    from .runs import (
        AskingOptimiser as AskingOptimiser,
        BatchedOptimiser as BatchedOptimiser,
        Card as Card,
        Enquiry as Enquiry,
        Optimiser as Optimiser,
        OptimiserFamily as OptimiserFamily,
        run as run,
        run_batch as run_batch,
    )
    from .space import SearchSpace as SearchSpace
    from .starts import Window as Window, settings as settings, shown as shown
    from .uncertainty import (
        Uncertainty as Uncertainty,
    )
    from .value import Value as Value

__getattr__, __dir__ = offered(__name__)
