"""Differential evolutions and swarms of the CEC competitions, of the library minionpy.

Each an optimiser ``minion-...``; the library is imported when one of its names is asked for.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import ClassVar

import numpy as np

from springpot.identification import Optimiser, Recorder
from springpot.rheology import Real

from .cube import Cube, integer, keep_on
from .families import algorithms, family

PREFIX = "minion-"
INSTALL = "pip install 'springpot[race]'"
ALGORITHMS = {
    "lshade": ("LSHADE", "Tanabe and Fukunaga 2014, doi:10.1109/CEC.2014.6900380"),
    "jso": ("jSO", "Brest et al. 2017, doi:10.1109/CEC.2017.7969456"),
    "arrde": ("ARRDE", "Muzakka, github.com/khoirulmuzakka/Minion"),
    "jade": ("JADE", "Zhang and Sanderson 2009, doi:10.1109/TEVC.2009.2014613"),
    "j2020": ("j2020", "Brest et al. 2020, doi:10.1109/CEC48606.2020.9185551"),
    "lshade-cnepsin": ("LSHADE_cnEpSin", "Awad et al. 2017, doi:10.1109/CEC.2017.7969336"),
    "imode": ("IMODE", "Sallam et al. 2020, doi:10.1109/CEC48606.2020.9185577"),
    "agsk": ("AGSK", "Mohamed et al. 2020, doi:10.1109/CEC48606.2020.9185901"),
    "dms-pso": ("DMSPSO", "Liang and Suganthan 2005, doi:10.1109/SIS.2005.1501611"),
    "bipop-acma-es": ("BIPOP_aCMAES", "Hansen and Ros 2010, doi:10.1145/1830761.1830788"),
    "spso-2011": ("SPSO2011", "Zambrano-Bigiarini et al. 2013, doi:10.1109/CEC.2013.6557848"),
    "nl-shade-rsp": ("NLSHADE_RSP", "Stanovov et al. 2021, doi:10.1109/CEC45853.2021.9504959"),
    "lsrtde": ("LSRTDE", "Stanovov and Semenkin 2024, doi:10.1109/CEC60901.2024.10611907"),
}
"""The library's name of an algorithm and the source of the method."""
ENDED_BY_FEW = ("NLSHADE_RSP", "LSRTDE")
"""Algorithms that end the process where they are told of few evaluations.

With up to 7 a parameter the first, and with 20 to 40 the second, reads beyond its own tables in
version 1.9.1.
"""


@dataclass(frozen=True)
class Minion(Optimiser):
    """An algorithm of minionpy in the unit cube, with the library's own settings.

    Its schedules run over the whole budget, as in the competitions.
    """

    algorithm: ClassVar[str] = ""

    def minimise(self, problem: Recorder, budget: int, rng: np.random.Generator) -> None:
        """Search once over the budget, and anew with what is left of it."""
        cube = Cube(problem)
        keep_on(problem, lambda: self._attempt(cube, budget - problem.evaluations, rng))

    def _attempt(self, cube: Cube, budget: int, rng: np.random.Generator) -> None:
        from minionpy import Minimizer

        ended: list[BaseException] = []

        def values(points: Real, _: object = None) -> list[float]:
            # An exception that crosses the library comes out as another one: keep it until then.
            if not ended:
                try:
                    return [float(value) for value in cube.batch(np.asarray(points))]
                except BaseException as error:
                    ended.append(error)
            return [inf] * len(points)

        box = [(0.0, 1.0)] * cube.dimension
        if self.algorithm in ENDED_BY_FEW:
            # Fewer are no schedule beside populations of 30 and 20 a parameter; the recorder ends
            # the run.
            budget = max(budget, 60 * cube.dimension)
        Minimizer(values, box, None, self.algorithm, budget, None, integer(rng)).optimize()
        if ended:
            raise ended[0]


MEMBERS = algorithms(Minion, PREFIX, "minionpy", ALGORITHMS)
globals().update({kind.__name__: kind for kind in MEMBERS.values()})

OFFERS = "L-SHADE, jSO, IMODE, AGSK, ARRDE, SPSO-2011 and others of minionpy"
FAMILY = family(PREFIX, OFFERS, "minionpy", INSTALL, MEMBERS)
