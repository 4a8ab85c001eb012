"""Commands of test reports."""

COMMANDS = {
    "cycles": (
        "springpot.testreport.commands.cycles",
        "Cycles of a test: stiffness, damping, energy, each with its interval.",
    ),
}
