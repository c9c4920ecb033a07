"""``harness watch``. What reads and serves is imported when it is called: ``--help`` does not wait for it."""

from pathlib import Path
from typing import Annotated

import typer

from harness.authoring.commands import say


def watch(
    folder: Annotated[
        Path,
        typer.Argument(
            help="The experiment's folder; or a folder or a file that harness audit --out wrote.", metavar="DIR|FILE"
        ),
    ],
    port: Annotated[
        int, typer.Option(help="The port of the page. 0: any port that is free.", metavar="N", min=0, max=65535)
    ] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open it in the browser.")] = True,
) -> None:
    """Show recorded episodes in the browser. While a run goes on, the page says when more cells have ended.

    Of a search for cheats: the behaviours that it found.
    """
    from .watch import HOST, open_server, pages_of

    pages = pages_of(folder)
    pages.page()  # what is wrong with the folder is said here
    with open_server(pages, port) as server:
        address = f"http://{HOST}:{server.server_port}/"
        say(f"Replay: {address} (Ctrl+C ends it)", err=True)
        if browser:
            import webbrowser

            webbrowser.open(address)
        server.serve_forever()


vars(watch)["examples"] = (
    "harness watch my-results",
    "harness watch my-results --no-browser --port 8000",
    "harness watch my-cheats",
)
