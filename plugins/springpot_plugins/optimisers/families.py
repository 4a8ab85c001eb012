"""Libraries of many optimisers: their algorithms as classes, and the family that offers them."""

from __future__ import annotations

from collections.abc import Mapping
from importlib.util import find_spec

from springpot.errors import ModelError
from springpot.identification import Card, Optimiser, OptimiserFamily


def algorithms(
    base: type[Optimiser], prefix: str, library: str, about: Mapping[str, tuple[str, str]]
) -> dict[str, type[Optimiser]]:
    """A class for each algorithm of a library, by our name of it.

    Parameters
    ----------
    base : type of Optimiser
        Whose `algorithm` is the library's name of one.
    prefix, library : str
        Before each of our names, and the distribution that does the work.
    about : mapping of str to tuple of str
        By our name: the library's, and the source of the method.
    """
    made = {}
    for name, (algorithm, citation) in about.items():
        card = Card(f"{algorithm} of {library}", citation, distribution=library)
        space = {"name": prefix + name, "card": card, "algorithm": algorithm}
        # In the module of its base, where a worker finds it by its own name.
        space |= {"__module__": base.__module__, "__doc__": base.__doc__}
        made[prefix + name] = type(f"{base.__name__}_{algorithm}", (base,), space)
    return made


def family(
    prefix: str, offers: str, library: str, install: str, members: Mapping[str, type[Optimiser]]
) -> OptimiserFamily:
    """The optimisers of a library, which says how to get it where it is absent."""

    def installed() -> dict[str, type[Optimiser]]:
        if find_spec(library) is None:
            raise ModelError(f"optimisers {prefix}... need {library}: {install}")
        return dict(members)

    return OptimiserFamily(f"{prefix}NAME", offers, installed)
