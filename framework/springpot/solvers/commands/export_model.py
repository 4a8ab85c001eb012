"""``springpot export-model``: an identified model for a solver."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from springpot.cli.common import DATA, FILE, POSITIVE, emit, json_option, note_to_stderr, numbers

EXAMPLE = "Example: springpot export-model fit.json --to opensees --band 1Hz:48Hz --tolerance 0.5%"


@click.command("export-model", epilog=EXAMPLE)
@click.argument("source", type=DATA, metavar="FIT.json|MODEL|DATA")
@click.option(
    "--to", "format_name", metavar="FORMAT", required=True, help="See 'springpot list writers'."
)
@click.option(
    "--band",
    metavar="LOW:HIGH",
    help="Frequencies such as 1Hz:48Hz or 6rad/s:300rad/s; of DATA where they were measured.",
)
@click.option("--tolerance", metavar="X%", help="Largest error of K on the band; 0.5% by default.")
@click.option("--terms", type=POSITIVE, metavar="N", help="That many terms instead of a tolerance.")
@click.option(
    "--times", metavar="LOW:HIGH", help="Relaxation times in s, such as 1e-6:1e6; of DATA too."
)
@click.option(
    "--per-decade", type=POSITIVE, default=1, show_default=True, metavar="N", help="Of such times."
)
@click.option("--dashpot", is_flag=True, help="Let a dashpot stand beside the terms.")
@click.option(
    "--set",
    "values",
    multiple=True,
    metavar="NAME=VALUE",
    help="A parameter of MODEL; repeat for each.",
)
@click.option("--unit", metavar="UNIT", help="Of the stiffness of MODEL, such as kN/m or MPa.")
@click.option(
    "--without",
    multiple=True,
    metavar="EFFECT",
    help="Leave out an effect of the rig; may be repeated.",
)
@click.option(
    "--temperature", type=float, metavar="DEGC", help="For models with a temperature effect."
)
@click.option(
    "--amplitude",
    metavar="X[,X...]",
    help="Where a model is not linear: its first harmonic there, one material for each.",
)
@click.option(
    "--poisson", type=float, metavar="NU", help="Poisson's ratio, for formats of solid materials."
)
@click.option("--modulus", metavar="KIND", help="shear, young or bulk, where the data do not say.")
@click.option(
    "--bulk", metavar="WAY", help="Bulk modulus constant or relaxing; constant above NU = 0.45."
)
@click.option(
    "-o", "--output", type=FILE, metavar="FILE", help="Where to write; by default to the screen."
)
@json_option
def command(
    source: str,
    format_name: str,
    output: Path | None,
    as_json: bool,
    tolerance: str | None,
    amplitude: str | None,
    times: str | None,
    per_decade: int,
    **options: Any,
) -> None:
    """Write a model for a solver: identified, or given by its parameters.

    An identified one is the JSON of 'springpot identify --json'. It becomes a Prony series of as
    few terms as the tolerance on the band needs, or one of given --times, which DATA may be too.
    Effects of rig and signals are refused, for they
    do not belong to the specimen: leave them out with --without.
    """
    from springpot.constraints import times_of
    from springpot.errors import OptionError
    from springpot.files import write_text, write_with
    from springpot.solvers.exporting import exported

    if amplitude is not None:
        options["amplitudes"] = numbers(amplitude)
    if times is not None:
        options["times"] = times_of(times, per_decade)
    handed = exported(source, format_name, tolerance=tolerance, **options)
    data = handed.data
    if data is not None:
        # Bytes on a terminal are unreadable, and may command it.
        if output is None:
            raise OptionError(
                f"{handed.writer.name} is no text: name its file, -o damper{handed.writer.suffix}"
            )
        write_with(output, lambda file: file.write(data))
    elif output is not None:
        write_text(output, handed.text)
    path = None
    if output is not None:
        path = str(output)
    result = {"schema": "springpot.export-model/1", **handed.to_dict(), "file": path}
    emit(result, as_json, lambda: _show(handed.text, result, output))
    # Beside the card, which may go to a file or through a pipe.
    if handed.outside:
        note_to_stderr(source, handed.outside)


def _show(text: str, result: dict[str, Any], output: Path | None) -> None:
    if output is None:
        # The file as it is and nothing else, so that it can be redirected.
        print(text, end="")
        return
    error = f"{100 * result['error']:.2g} %"
    print(
        f"{result['terms']} terms, within {error} of |K| of the model on the band, written to"
        f" {output}"
    )
