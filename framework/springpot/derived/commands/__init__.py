"""Commands of derived quantities."""

COMMANDS = {
    "quantities": (
        "springpot.derived.commands.quantities",
        "Crossover, plateau, viscosity, linear limit ...: each with its interval.",
    ),
}
