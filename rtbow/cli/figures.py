"""The verb ``rtbow figures``: the paper's figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from rtbow.cli.options import backend_option, progress_bar, quiet_option, size_option


@click.command()
@click.option("-o", "--output", "output", required=True, metavar="DIR", help="Folder to write to.")
@click.option(
    "--only", multiple=True, metavar="NAME", help="A figure, such as fig5f. May be repeated."
)
@size_option("Width and height in pixels; left out: 480x270.")
@backend_option
@quiet_option
def figures(
    output: str, only: tuple[str, ...], size: tuple[int, int] | None, backend: Any, quiet: bool
) -> None:
    """Render the paper's figures, with a page of pictures and measured claims.

    Finished frames are kept: an interrupted run goes on where it stopped.

    Example: rtbow figures -o figures --only fig5f
    """  # fmt: skip
    from rtbow.study.figures import DEFAULT_SIZE, make_figures

    verdicts = make_figures(
        Path(output),
        list(only),
        size or DEFAULT_SIZE,
        backend,
        lambda name: progress_bar(name, quiet),
    )
    if not quiet:
        for verdict in verdicts:
            state = {True: "holds", False: "does not hold", None: "not measured"}[verdict.holds]
            click.echo(f"figure {verdict.claim.figure}: {state}: {verdict.claim.text}")
        click.echo(str(Path(output) / "index.html"))
