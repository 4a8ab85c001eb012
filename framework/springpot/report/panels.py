"""Figures inside a page: each a small picture by itself, so that a narrow screen stacks them."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable, Iterator
from io import BytesIO
from typing import TYPE_CHECKING

from springpot.markup import Html, joined, tag

from . import views
from .canvas import COLOURS, blank
from .residuals import PLANES, draw_plane
from .scene import Scene, sweep_colours

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 4.6, 3.3
"""Inches of a panel; at these, its letters are as large as those of the page."""

VIEWS: tuple[tuple[str, Callable[[Axes, Scene], None]], ...] = (
    ("Loss factor", views.loss_factor),
    ("Cole-Cole: loss against storage", views.cole_cole),
    ("Black: size against phase", views.black),
    ("van Gurp-Palmen: phase against size", views.van_gurp_palmen),
)


def panel(
    draw: Callable[[Axes], None], caption: str, width: float = WIDTH, height: float = HEIGHT
) -> Html:
    """A figure with its caption as an element of a page.

    Parameters
    ----------
    draw : callable
        Draws on a pair of axes.
    caption : str
        Below the figure; also read aloud in its place.
    width, height : float
        In inches.
    """
    with blank(width, height) as figure:
        draw(figure.subplots())
        return framed(figure, caption)


def framed(figure: Figure, caption: str) -> Html:
    """A figure that is drawn already; see `panel`."""
    picture = BytesIO()
    # Without a date: the same answer gives the same page.
    figure.savefig(picture, format="svg", metadata={"Date": None})
    width, height = figure.get_size_inches().tolist()
    # Inside the page, and as a picture: an SVG that stands in an image runs no script.
    source = f"data:image/svg+xml;base64,{b64encode(picture.getvalue()).decode()}"
    # The browser knows the room before the picture is there; an inch of a page is 96 pixels.
    size = {"width": f"{96 * width:.0f}", "height": f"{96 * height:.0f}"}
    return tag("figure", tag("img", src=source, alt=caption, **size), tag("figcaption", caption))


def pairs(scenes: dict[str, Scene], draw: Callable[[Axes, Scene], None], caption: str) -> Html:
    """The same view of several scenes side by side, each with its name."""
    figures = [
        panel(lambda axes, s=scene: draw(axes, s), f"{caption} · {name}")  # type: ignore[misc]
        for name, scene in scenes.items()
    ]
    return tag("div", *figures, class_="pair")


def data_and_model(scenes: dict[str, Scene]) -> Html:
    """Storage and loss, and the residual in per cent."""
    return joined(
        [
            pairs(scenes, views.storage_and_loss, "Storage and loss"),
            pairs(scenes, views.residual, "Measured minus model in per cent of |K|"),
        ]
    )


def other_views(scenes: dict[str, Scene]) -> Html:
    """Loss factor, Cole-Cole, Black and van Gurp-Palmen."""
    return joined(pairs(scenes, draw, caption) for caption, draw in VIEWS)


def residual_planes(scenes: dict[str, Scene]) -> Iterator[Html]:
    """The four planes, each with what it shows."""
    for plane in PLANES:
        yield tag("h3", f"{plane.name.capitalize()} plane: {plane.says}")
        yield pairs(
            scenes,
            lambda axes, scene, p=plane: draw_plane(axes, scene, p),  # type: ignore[misc]
            f"Residual, {plane.name}",
        )


def keys(scene: Scene) -> Html:
    """What marks and colours mean."""
    text = (
        "Points are measured, lines fitted. Filled and solid: storage, or the real part; open and"
        " dashed: loss, or the imaginary part. The band is what noise explains (two standard"
        " deviations); where sweeps differ, each has its own in its colour."
    )
    # The colours mean what they mean in the pictures: sweeps where there are several, else the two
    # parts.
    if scene.by_sweep:
        colours, labels = sweep_colours(len(scene.sweeps)), [sweep.label for sweep in scene.sweeps]
    else:
        colours, labels = list(COLOURS[:2]), ["storage", "loss"]
    swatches = [
        tag("span", tag("i", style=f"background:{colour}"), label, class_="key")
        for colour, label in zip(colours, labels, strict=True)
    ]
    if scene.drawn:
        text += f" {scene.drawn}, evenly spread; errors are those of all."
    if scene.aside is not None:
        text += " Open diamonds: single points that were set aside; no model was fitted to them."
    return joined([tag("p", text, class_="quiet"), tag("p", *swatches)])
