"""A command of the example plugin.

The entry point of the group `springpot.commands` names its table.
"""

from __future__ import annotations

import click

COMMANDS = {
    "peak-loss": ("springpot_example_command", "The frequency at which the loss is largest.")
}


@click.command("peak-loss", epilog="Example: springpot peak-loss example-data")
@click.argument("data")
def command(data: str) -> None:
    """At which of the measured frequencies DATA lose most."""
    import springpot  # here, so that 'springpot --help' does not wait for it

    measured = springpot.read(data)
    omega = measured.omega[measured.loss.argmax()]
    click.echo(f"the loss is largest at {omega:.4g} rad/s")
