"""The replay of an experiment in the browser, while it goes on."""

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from harness.authoring.commands import (
    Store,
    complain,
    describe_unexpected,
    line_names,
    load_registry,
    overview_of,
    overview_row,
    shows_of,
)
from harness.authoring.pages import question, render_page, replay_of
from harness.errors import HarnessError, UsageError, one_line
from harness.results import Results, load_results

if TYPE_CHECKING:
    from http.server import ThreadingHTTPServer

TEMPLATE = Path(__file__).parent / "watch.html.j2"
HOST = "127.0.0.1"
"""Nobody else on the network sees the page."""
CERTIFICATES = "watch--certificates"
"""Under this name a plugin registers what makes the page of certificates."""
PATIENCE = 60.0
"""Seconds to wait for a client that asks nothing."""


def pages_of(path: Path) -> "Pages | CertificatePages":
    """The pages of an experiment, or of certificates, of which the plugin that writes them makes a page."""
    registry = load_registry()
    if not Store.is_experiment(path) and CERTIFICATES in registry.names("commands"):
        page_in: Callable[[Path], str | None] = registry.get("commands", CERTIFICATES).load()
        if page_in(path) is not None:
            return CertificatePages(path, page_in)
    return Pages(path)


@dataclass(frozen=True)
class CertificatePages:
    """The page of certificates, made anew whenever it is asked for.

    Attributes:
        path: A folder, or one certificate.
        page_in: Makes the page of what it names; None where nothing is there any more.
    """

    path: Path
    page_in: Callable[[Path], str | None]

    def state(self) -> str:
        """Always the same: the page does not ask."""
        return ""

    def page(self) -> str:
        """The page as HTML.

        Raises:
            HarnessError: Nothing is there any more, or it cannot be read.
        """
        page = self.page_in(self.path)
        if page is None:
            raise UsageError(f"'{self.path}' has no certificate any more")
        return page


class Pages:
    """What there is to be served; the page is made again when cells have ended since."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._made = folder, ("", "")

    def state(self) -> str:
        """Another text whenever cells have ended."""
        return str(sum(1 for _ in self._folder.glob("cells/[!.]*/manifest.json")))

    def page(self) -> str:
        """The page as HTML.

        Raises:
            HarnessError: The folder cannot be read.
        """
        state = self.state()
        if self._made[0] != state:
            results = load_results(self._folder)
            self._made = state, watch_page(results, state)
        return self._made[1]


def open_server(pages: Pages | CertificatePages, port: int) -> "ThreadingHTTPServer":
    """A server of `pages` on this machine alone.

    Raises:
        UsageError: The port is taken.
    """
    from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

    routes: dict[str, tuple[str, Callable[[], str]]] = {
        "/": ("text/html; charset=utf-8", pages.page),
        "/state": ("text/plain; charset=utf-8", pages.state),
    }

    class Server(ThreadingHTTPServer):
        """A server whose clients may leave at any time."""

        def handle_error(self, request: object, client_address: object) -> None:
            """Say in a line what nobody foresaw; a client that left, as a browser does, is foreseen."""
            error = sys.exception()
            if isinstance(error, Exception) and not isinstance(error, ConnectionError | TimeoutError):
                complain(describe_unexpected(error))

    class Handler(BaseHTTPRequestHandler):
        """Answers the two addresses of the page."""

        timeout = PATIENCE

        def do_GET(self) -> None:
            """Answer with a page, or with its state."""
            route = routes.get(self.path)
            name = self.headers.get("Host", "").rpartition(":")[0]
            if route is None or name not in {HOST, "localhost"}:  # no page of elsewhere asks by another name
                self.send_error(404)
                return
            kind, make = route
            try:
                text = make()
            except (HarnessError, OSError) as error:  # the folder may be gone by now
                self.send_error(500, explain=one_line(error))  # in the body: the status line is Latin-1
                return
            self.send_response(200)
            self.send_header("Content-Type", kind)
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(text.encode(errors="backslashreplace"))

        def log_message(self, format: str, *values: object) -> None:  # noqa: A002
            """Say nothing: the terminal is the user's."""

    try:
        return Server((HOST, port), Handler)
    except OSError as error:
        raise UsageError(f"--port {port} cannot be had: {error.strerror}. Give another, or leave it out") from error


def _answers(results: Results) -> tuple[tuple[str, ...], list[tuple[str, ...]]] | None:
    """The comparisons so far: headings, and a row for each; None before there is one."""
    combinations = [it for it in results.combinations if it.seeds]
    if not combinations:
        return None
    overview, names = overview_of(combinations), line_names(combinations)
    rows = [overview_row(name, it, True, overview) for name, it in zip(names, combinations, strict=True)]
    return overview.headings, rows


def watch_page(results: Results, state: str) -> str:
    """The page, as HTML.

    Args:
        results: The experiment as it stands.
        state: What the address ``/state`` answers as long as nothing new is there to be shown.

    Raises:
        UsageError: A library of the extra ``report`` is missing.
        SchemaError: A file is damaged or written by a newer version.
    """
    return render_page(
        TEMPLATE,
        "The replay",
        title=question(results),
        status=f"{len(results.done)} of {len(results.manifests)} cells are done.",
        state=state,
        answers=_answers(results),
        replay=replay_of(shows_of(results)),
    )
