"""The built-in optimisers, one small file for each library or family.

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
    from . import (
        annealing,
        auto,
        evolution,
        hopping,
        leastsquares,
        lshade,
        native,
        nloptlib,
        presets,
        sampling,
        spso,
        swarm,
    )

    return (
        swarm.PaperSwarm,
        swarm.ScalarSwarm,
        spso.StandardSwarm,
        evolution.CmaEs,
        evolution.BipopCmaEs,
        presets.IpopCmaEs,
        evolution.DifferentialEvolution,
        presets.StornPrice,
        lshade.LShade,
        nloptlib.Crs,
        nloptlib.Isres,
        nloptlib.Esch,
        nloptlib.DirectL,
        nloptlib.Mlsl,
        nloptlib.Sbplx,
        nloptlib.Bobyqa,
        nloptlib.NelderMead,
        nloptlib.Lbfgs,
        annealing.DualAnnealing,
        annealing.ScipyDirect,
        hopping.BasinHopping,
        hopping.Cobyqa,
        hopping.Shgo,
        leastsquares.LeastSquares,
        leastsquares.AlternatingLeastSquares,
        native.Native,
        auto.Auto,
        sampling.RandomSearch,
    )


@hookimpl
def springpot_optimiser_families() -> Iterable[OptimiserFamily]:
    """Libraries of many."""
    from . import (
        dfo,
        lipo_library,
        minion,
        minuit,
        nevergrad_library,
        pymoo_library,
        surrogate,
        unified,
    )

    return (
        unified.FAMILY,
        minion.FAMILY,
        dfo.FAMILY,
        minuit.FAMILY,
        pymoo_library.FAMILY,
        nevergrad_library.FAMILY,
        surrogate.FAMILY,
        lipo_library.FAMILY,
    )
