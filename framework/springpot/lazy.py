"""What is loaded only when it is asked for: names of a package, pictures and texts of results.

A package itself costs nothing. Results live below the room that makes pictures, and must not import
it: its name here is the only thread upwards, and whoever draws nothing never loads a library of
pictures.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def offered(package: str) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """The module functions ``__getattr__`` and ``__dir__`` of a package.

    It offers what it imports for type checkers, so that each name stands once; see SPEC 1 of
    Scientific Python, lazy loading of submodules and functions.

    Parameters
    ----------
    package : str
        Its name.
    """

    @cache
    def where() -> dict[str, str]:
        # Not for whoever imports a package and asks for nothing of it.
        import ast
        from linecache import getlines

        module = sys.modules[package]
        # Of its file, whoever has loaded it: pytest's loader keeps no source.
        parts = ast.parse("".join(getlines(str(module.__file__), vars(module)))).body
        imports = [each for part in parts if isinstance(part, ast.If) for each in part.body]
        return {
            name.name: "." * each.level + (each.module or name.name)
            for each in imports
            if isinstance(each, ast.ImportFrom)
            for name in each.names
        }

    def get(name: str) -> Any:
        if name.startswith("__") or name not in where():
            raise AttributeError(f"module '{package}' has no attribute '{name}'")
        module = import_module(where()[name], package)
        # A module that is offered by its own name.
        if module.__name__ == f"{package}.{name}":
            return module
        return getattr(module, name)

    def listed() -> list[str]:
        return sorted(where())

    return get, listed


# As names, not as imports: the rooms below must not know the one above.
DRAWS, TELLS = "springpot.report.result_plots", "springpot.report.told"


def draw(
    result: object, path: str | Path | None = None, axes: Axes | None = None
) -> Figure | Axes | Path:
    """Draw a result on axes that are given, into a file, or on a figure of its own.

    Parameters
    ----------
    result : object
        Anything that `springpot.report.result_plots` knows.
    path : str or Path, optional
        Where to write; the suffix (.png, .svg, .pdf) chooses the format.
    axes : matplotlib.axes.Axes, optional
        Where to draw; the figure is then the caller's.

    Returns
    -------
    Axes, Path or Figure
        The axes that were given, the file that was written, or a figure that shows itself in a
        notebook.

    Raises
    ------
    OutputError
        If matplotlib is missing, the file cannot be written, or both places are given.
    """
    drawn: Figure | Axes | Path = import_module(DRAWS).drawn(result, path, axes)
    return drawn


def draw_view(
    result: object, view: str, path: str | Path | None = None, axes: Axes | None = None
) -> Figure | Axes | Path:
    """One view of a fit, as wide as a journal's column where no axes are given; see `draw`."""
    drawn: Figure | Axes | Path = import_module(DRAWS).one_view(result, view, path, axes)
    return drawn


class Drawn:
    """What has a picture."""

    def plot(
        self, path: str | Path | None = None, *, ax: Axes | None = None
    ) -> Figure | Axes | Path:
        """The picture of it, on a figure of its own, in a file, or on axes that are given.

        Parameters
        ----------
        path : str or Path, optional
            Where to write; the suffix (.png, .svg, .pdf) chooses the format.
        ax : matplotlib.axes.Axes, optional
            Draw there instead, where one pair of axes is enough.

        Returns
        -------
        Figure, Path or Axes
            A figure that shows itself in a notebook; the file that was written; or the axes that
            were given.

        Raises
        ------
        OutputError
            If matplotlib is missing, the file cannot be written, both places are given, or one pair
            of axes does not hold the picture.
        """
        return draw(self, path, ax)


class Printed:
    """An answer whose text is what the command line prints of it, in notebooks as a page."""

    def __str__(self) -> str:
        text: str = import_module(TELLS).told(self)
        return text

    def _repr_html_(self) -> str:
        page: str = import_module(TELLS).shown(self)
        return page
