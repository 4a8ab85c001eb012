"""Registered data sets: what they are and how to load them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from springpot.errors import DataError, SpringpotError
from springpot.owners import described, owned

from .measurement import Measurement


@dataclass(frozen=True)
class DataSet:
    """A data set that can be named instead of a file.

    Parameters
    ----------
    name : str
        What users type.
    summary : str
        One sentence on what was measured, or that nothing was.
    load : callable
        Gives the measurement; called only when the set is used.
    kind : str
        ``measured``, ``artificial`` or ``reconstruction`` (computed from published parameters,
        never measured).
    licence : str
        Terms under which the numbers may be used.
    citation : str
        Who measured, where it was published.
    doi, origin : str
        Of the publication, and where the numbers can be got.
    size : int
        Number of points, 0 if unknown before loading.
    truth : mapping of str to float
        Element parameters behind artificial data and reconstructions.
    model : str
        Model behind them, or the one used in the literature.
    fit : str
        What the literature found with it.
    test : str
        Instrument, geometry and kind of test.
    columns : tuple of str
        What is given, with units: ``omega [rad/s]``.
    stiffness_scale : float or None
        The paper's k-bar for these data.
    physics : tuple of str
        What is known to be in the data: friction, a shift with temperature, an artefact of the
        instrument.
    aliases : tuple of str
        Other names.
    remote : str
        Address from which it is downloaded when it is first used; empty where it is on this
        machine.
    unavailable : str
        Empty, or why the set cannot be loaded here and how to mend it.

    Examples
    --------
    >>> import numpy as np
    >>> from springpot import Measurement
    >>> from springpot.measurement import DataSet
    >>> two_points = Measurement([1.0, 2.0], [1j, 2j])
    >>> DataSet("two-points", "made up", lambda: two_points, kind="artificial").open()
    <Measurement measurement: 2 points, 0.159 to 0.318 Hz>
    """

    name: str
    summary: str
    load: Callable[[], Measurement]
    kind: str = "measured"
    licence: str = ""
    citation: str = ""
    doi: str = ""
    origin: str = ""
    size: int = 0
    truth: dict[str, float] = field(default_factory=dict)
    model: str = ""
    fit: str = ""
    test: str = ""
    columns: tuple[str, ...] = ()
    stiffness_scale: float | None = None
    physics: tuple[str, ...] = ()
    aliases: tuple[str, ...] = ()
    remote: str = ""
    unavailable: str = ""

    @property
    def where(self) -> str:
        """In one word: ``here``, ``download``, or ``missing``."""
        if self.unavailable:
            return "missing"
        if self.remote:
            return "download"
        return "here"

    def open(self) -> Measurement:
        """The measurement.

        Raises
        ------
        DataError
            If the set is unavailable here, or its plugin fails.
        """
        if self.unavailable:
            raise DataError(f"data set '{self.name}' is unavailable: {self.unavailable}")
        try:
            loaded = self.load()
        except DataError as error:
            raise DataError(f"{owned('data set', self.name)}: {error}") from error
        except (SpringpotError, MemoryError):
            raise
        except Exception as error:
            raise DataError(
                f"{owned('data set', self.name)} cannot be loaded: {described(error)}"
            ) from error
        if not isinstance(loaded, Measurement):
            raise DataError(
                f"{owned('data set', self.name)} gives {loaded!r:.80}, which is no measurement"
            )
        return loaded
