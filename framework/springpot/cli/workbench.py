"""``springpot workbench``: the missing effect found by pointing, in a browser on this machine."""

from __future__ import annotations

import click

from .common import MODEL


@click.command("workbench", epilog="Example: springpot workbench damper.csv --model fractional-maxwell")
@click.argument("data", metavar="[DATA|SESSION.json]", required=False)
@click.option("--model", "-m", metavar="EXPR", help=f"{MODEL} Without it any linear passive material is judged.")
@click.option("--port", type=click.IntRange(0, 65535), default=0, metavar="N", help="Where to listen; a free port.")
@click.option("--no-browser", is_flag=True, help="Print the address only.")
def command(data: str | None, model: str | None, port: int, no_browser: bool) -> None:
    """Open a page on which data are dropped, effects pointed at and accepted, and the error falls.

    The address is printed first; Ctrl-C ends it. Nothing leaves this machine.
    """
    from springpot.web.launch import serve

    serve(data, model, port, not no_browser, click.echo)
