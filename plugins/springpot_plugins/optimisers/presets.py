"""Methods as their authors run them, where a library's own settings are others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from springpot.identification import Card

from .evolution import CmaEs, DifferentialEvolution


@dataclass(frozen=True)
class IpopCmaEs(CmaEs):
    """CMA-ES of pycma as Auger and Hansen ran it at CEC 2005.

    The first step is half of the box, and the population doubles at each restart.

    Parameters
    ----------
    sigma : float
        Initial step as a part of the box.
    population : int
        Points of a generation; 0 takes 4 + 3 ln d.
    growth : float
        Factor on the population at each restart.
    """

    sigma: float = 0.5

    name: ClassVar[str] = "ipop-cma-es"
    card: ClassVar[Card] = Card(
        "covariance matrix adaptation, a doubling population, as its authors run it (pycma)",
        "Auger and Hansen 2005, doi:10.1109/CEC.2005.1554902, section 2",
        started=True,
    )


@dataclass(frozen=True)
class StornPrice(DifferentialEvolution):
    """Differential evolution of SciPy with the settings that Storn and Price recommend.

    DE/rand/1/bin, ten points a parameter, F = 0.5 and CR = 0.9.

    Parameters
    ----------
    strategy : str
        SciPy's name of the mutation.
    population : int
        Points of a generation for each parameter.
    mutation : tuple of float
        Range of the factor on differences.
    recombination : float
        Probability of taking a component of the mutant.
    """

    strategy: str = "rand1bin"
    population: int = 10
    mutation: tuple[float, float] = (0.5, 0.5)
    recombination: float = 0.9

    name: ClassVar[str] = "de-storn-price"
    card: ClassVar[Card] = Card(
        "differential evolution rand/1/bin, as its authors run it (SciPy)",
        "Storn and Price 1997, doi:10.1023/A:1008202821328, section 5",
        started=True,
    )
