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
    from . import cube, descents, evolution, searches, swarm

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
        searches.Crs,
        searches.Isres,
        searches.Esch,
        searches.DirectL,
        searches.Mlsl,
        searches.Sbplx,
        searches.Bobyqa,
        searches.NelderMead,
        searches.Lbfgs,
        searches.DualAnnealing,
        searches.ScipyDirect,
        searches.BasinHopping,
        searches.Cobyqa,
        searches.Shgo,
        descents.LeastSquares,
        descents.AlternatingLeastSquares,
        descents.Native,
        descents.Auto,
        cube.RandomSearch,
    )


@hookimpl
def springpot_optimiser_families() -> Iterable[OptimiserFamily]:
    """Libraries of many."""
    from . import libraries, unified

    return (unified.FAMILY, *libraries.FAMILIES)
