"""Commands of the workbench."""

COMMANDS = {
    "workbench": (
        "springpot.web.commands.workbench",
        "The whole loop in a browser: point at an effect, accept it, undo.",
    ),
}
