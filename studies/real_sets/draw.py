"""One picture for each set.

Data and model before and after the accepted effects, and the ladder between.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from springpot.diagnosis import Ladder, Step
from springpot.measurement import Measurement
from springpot.report import views
from springpot.report.canvas import blank, save
from springpot.report.figures import headed
from springpot.report.ladder_text import draw_ladder
from springpot.report.views import DrawnFit, Scene


def draw(ladder: Ladder, path: Path) -> None:
    """Storage and loss above, residuals below.

    The first model, the last one, and the ladder between them.
    """
    ends = [ladder.steps[0], ladder.steps[-1]] if len(ladder.steps) > 1 else [ladder.steps[0]]
    with blank(4.6 * (len(ends) + 1) + 1.6, 6.4) as figure:
        grid = figure.add_gridspec(2, len(ends) + 1, height_ratios=(3, 1.4))
        for column, (step, title) in enumerate(zip(ends, ("before", "after"), strict=False)):
            scene = _scene(step)
            above, below = (figure.add_subplot(grid[row, column]) for row in (0, 1))
            views.storage_and_loss(above, scene)
            views.residual(below, scene)
            above.set(title=title if len(ends) > 1 else "", xlabel="")
            if column:
                above.set_ylabel("")
                below.set_ylabel("")
        draw_ladder(figure.add_subplot(grid[:, -1]), ladder)
        # The points are means of repeats, whose scatter the error of a rung holds.
        headed(figure, scene, error=ends[-1].relative_rms)
        save(figure, path)


def _scene(step: Step) -> Scene:
    """Averaged data with the standard deviations of the noise, and the model of one rung."""
    fit = step.case.search.base
    data: Measurement = replace(fit.data.mean, sd=fit.noise.sd)
    return Scene(data, [DrawnFit(fit.model, fit.theta)])
