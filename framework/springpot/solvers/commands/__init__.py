"""Commands that hand models to solvers."""

COMMANDS = {
    "export-model": (
        "springpot.solvers.commands.export_model",
        "A model for a solver: Prony series, cards, scripts.",
    ),
}
