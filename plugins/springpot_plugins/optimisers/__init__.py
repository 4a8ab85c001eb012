"""The built-in optimisers, those of libraries that need not be there in one file.

Files are imported when they are asked for.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from springpot.hooks import hookimpl

if TYPE_CHECKING:
    from springpot.identification import Optimiser, OptimiserFamily


@hookimpl
def springpot_optimisers() -> Iterable[type[Optimiser]]:
    """All of them."""
    from . import auto, cube, evolution, leastsquares, nloptlib, scipy_searches, swarm

    return (
        swarm.PaperSwarm,
        swarm.ScalarSwarm,
        swarm.StandardSwarm,
        evolution.CmaEs,
        evolution.BipopCmaEs,
        evolution.IpopCmaEs,
        evolution.DifferentialEvolution,
        evolution.StornPrice,
        evolution.LShade,
        nloptlib.Crs,
        nloptlib.Isres,
        nloptlib.Esch,
        nloptlib.DirectL,
        nloptlib.Mlsl,
        nloptlib.Sbplx,
        nloptlib.Bobyqa,
        nloptlib.NelderMead,
        nloptlib.Lbfgs,
        scipy_searches.DualAnnealing,
        scipy_searches.ScipyDirect,
        scipy_searches.BasinHopping,
        scipy_searches.Cobyqa,
        scipy_searches.Shgo,
        leastsquares.LeastSquares,
        leastsquares.AlternatingLeastSquares,
        leastsquares.Native,
        auto.Auto,
        cube.RandomSearch,
    )


@hookimpl
def springpot_optimiser_families() -> Iterable[OptimiserFamily]:
    """Libraries of many."""
    from . import libraries, unified

    return (unified.FAMILY, *libraries.FAMILIES)
