"""``springpot workbench``: the missing effect found by pointing, in a browser on this machine."""

from __future__ import annotations

import click

from springpot.cli.common import MODEL, json_option, print_json


@click.command(
    "workbench", epilog="Example: springpot workbench damper.csv --model fractional-maxwell"
)
@click.argument("data", metavar="[DATA|SESSION.json]", required=False)
@click.option(
    "--model",
    "-m",
    metavar="EXPR",
    help=f"{MODEL} Without it any linear passive material is judged.",
)
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=0,
    metavar="N",
    help="Where to listen; a free port.",
)
@click.option(
    "--watch",
    metavar="DIR",
    default="",
    help="Watch a folder: rows join the data as its files grow.",
)
@click.option("--no-browser", is_flag=True, help="Print the address only.")
@json_option
def command(
    data: str | None,
    model: str | None,
    port: int,
    watch: str,
    no_browser: bool,
    as_json: bool,
) -> None:
    """Open a page on which data are dropped, effects pointed at and accepted, and the error falls.

    The address is printed first; Ctrl-C ends it. Nothing leaves this machine.
    """
    # Only when it runs: ``--help`` need not wait for the modules of a server.
    from springpot.web.launch import Workbench, serve

    def tell(bench: Workbench) -> None:
        if as_json:
            # One line: who started it reads the address by line while the server runs.
            print_json({"schema": "springpot.address/1", "address": bench.address}, line=True)
        else:
            click.echo(f"springpot workbench: {bench.address}")

    serve(data, model, port, not no_browser, tell, watch)
