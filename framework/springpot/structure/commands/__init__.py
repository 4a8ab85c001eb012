"""Commands of structures."""

COMMANDS = {
    "simulate": (
        "springpot.structure.commands.simulate",
        "A structure with identified dampers under a record.",
    ),
}
