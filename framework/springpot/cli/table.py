"""The commands: where each lives and its line in ``springpot --help``.

A new command is one module with a click command named `command`, and one line here. Nothing is imported from
it until it is called.
"""

from __future__ import annotations

from typing import NamedTuple


class Entry(NamedTuple):
    """Where a command lives and what it does, in one line."""

    module: str
    summary: str


COMMANDS: dict[str, Entry] = {
    "demo": Entry("springpot.cli.demo", "The whole story on embedded data, in under a minute."),
    "list": Entry("springpot.cli.listing", "Models, optimisers, effects, data sets or readers that are installed."),
    "inspect": Entry("springpot.cli.inspection", "What a file or data set holds: sweeps, ranges, units, origin."),
    "signals": Entry("springpot.cli.signals", "Time signals to dynamic stiffness, with its uncertainty."),
    "identify": Entry("springpot.cli.identify", "Parameters of a model from measurements, with their uncertainty."),
    "compare": Entry("springpot.cli.compare", "Models against one noise floor: how far off, where, how sure."),
    "mastercurve": Entry("springpot.cli.mastercurve", "Sweeps on one curve without a model: factors and laws."),
    "diagnose": Entry("springpot.cli.diagnose", "Which physical effect is missing from a model."),
    "discover": Entry("springpot.cli.discover", "Add missing effects one by one and watch the error fall."),
    "workbench": Entry(
        "springpot.cli.workbench", "The whole loop in a browser: point at an effect, accept it, undo."
    ),
    "run": Entry("springpot.cli.run", "Run a study, or resume it, and write its tables."),
    "tables": Entry("springpot.cli.tables", "Tables of a study that has been run."),
    "export": Entry("springpot.cli.export", "A study's results for IOHanalyzer, COCO, CSV or Parquet."),
    "predict": Entry("springpot.cli.predict", "Another test, from an identified model, with a band."),
    "export-model": Entry("springpot.cli.export_model", "A model for a solver: Prony series, cards, scripts."),
    "simulate": Entry("springpot.cli.simulate", "A structure with identified dampers under a record."),
    "init": Entry("springpot.cli.init", "Files to start from: a study, a plugin, a CI workflow."),
    "regression": Entry("springpot.cli.regression", "The accuracy gate for continuous integration."),
}
