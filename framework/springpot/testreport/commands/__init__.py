"""Commands of test reports."""

COMMANDS = {
    "cycles": (
        "springpot.testreport.commands.cycles",
        "Cycles of a test: stiffness, damping, energy, each with its interval.",
    ),
    "certify": (
        "springpot.testreport.commands.certify",
        "Whether tests are as a code asks, with their uncertainty, and why not.",
    ),
}
