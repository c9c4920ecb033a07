"""``harness watch``. What reads and serves is imported when it is called: ``--help`` does not wait for it."""

from pathlib import Path
from time import sleep
from typing import Annotated

import typer

from harness.cli.output import say
from harness.report.page.page import write_page


def watch(
    folder: Annotated[
        Path,
        typer.Argument(
            help="The folder of an experiment, or of recordings; or a folder or a file that harness audit --out wrote.",
            metavar="DIR|FILE",
        ),
    ],
    html: Annotated[
        Path | None,
        typer.Option(help="Write the page as it is now into a file, and serve nothing.", metavar="FILE"),
    ] = None,
    port: Annotated[
        int, typer.Option(help="The port of the page. 0: any port that is free.", metavar="N", min=0, max=65535)
    ] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open it in the browser.")] = True,
) -> None:
    """Show trainings in the browser while they go on. With success and pay, what is running, the answers and films.

    Of a search for cheats: the behaviours that it found.
    """
    from .watch import pages_of, served

    if html is not None:
        write_page(pages_of(folder, is_live=False)["/"](), html, "--html")
        say(f"Written: {html}", err=True)
        return
    with served(folder, port) as address:
        say(f"Live page: {address} (Ctrl+C ends it)", err=True)
        if browser:
            import webbrowser

            webbrowser.open(address)
        while True:
            sleep(3600.0)  # until Ctrl+C, which no wait without an end hears on Windows


vars(watch)["examples"] = (
    "harness watch my-results",
    "harness watch my-results --no-browser --port 8000",
    "harness watch my-recordings --html page.html",
    "harness watch my-cheats",
)
