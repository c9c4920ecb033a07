"""The page of trainings in the browser, while they go on."""

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from html import escape
from pathlib import Path
from threading import Lock, Thread
from typing import TYPE_CHECKING

from harness.authoring.commands import complain, describe_unexpected, line_names, overview_of, overview_row
from harness.authoring.pages import render_page
from harness.errors import HarnessError, UsageError, one_line
from harness.record import Store
from harness.registry import load_registry
from harness.report import question, replay_of
from harness.results import Results, load_results, shows_of

from .cards import rows_of
from .trainings import ExperimentSource, Shown, Training, source_of

if TYPE_CHECKING:
    from http.server import ThreadingHTTPServer

    from harness.authoring.pages import Replay

HERE = Path(__file__).parent
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

    def live(self) -> str:
        """Nothing: the page does not ask."""
        return "{}"

    results = live

    def page(self, is_live: bool = True) -> str:
        """The page as HTML; it never asks for more.

        Raises:
            HarnessError: Nothing is there any more, or it cannot be read.
        """
        page = self.page_in(self.path)
        if page is None:
            raise UsageError(f"'{self.path}' has no certificate any more")
        return page


class Pages:
    """What there is to be served, made when somebody asks; results anew when trainings have ended since."""

    def __init__(self, folder: Path) -> None:
        """Read nothing yet.

        Raises:
            UsageError: The folder holds neither an experiment nor a recording.
        """
        self._source, self._lock = source_of(folder), Lock()
        self._shown: tuple[Shown, str] | None = None
        self._results = -1, Told("", None)

    def live(self) -> str:
        """What the page asks for every second, as JSON: the parts that are shown anew, by their names."""
        with self._lock:
            shown = self._source.look()
            news, left = (escape(text) for text in (shown.news, shown.left))
            told = {"news": news, "left": left, "trainings": self._drawn(shown), "done": shown.done}
            return json.dumps(told)

    def results(self) -> str:
        """What follows from trainings that have ended, as JSON."""
        with self._lock:
            told = self._told(self._source.look().done)
        replay = told.replay
        parts = {"script": replay.script, "style": replay.style} if replay else {"script": "", "style": ""}
        return json.dumps({"answers": told.answers, "replay": told.replay_part, **parts})

    def page(self, is_live: bool = True) -> str:
        """The page as HTML.

        Args:
            is_live: Whether it asks for what is new; a file cannot.

        Raises:
            HarnessError: The folder cannot be read.
        """
        with self._lock:
            shown = self._source.look()
            told = self._told(shown.done)
            return render_page(
                HERE / "watch.html.j2",
                "The page",
                title=told.title or f"Trainings in {self._source.folder.resolve().name}",
                shown=shown,
                trainings=self._drawn(shown),
                answers=told.answers,
                replay=told.replay,
                replay_part=told.replay_part,
                is_live=is_live,
            )

    def _drawn(self, shown: Shown) -> str:
        """The cards, drawn again when something is new."""
        if self._shown is None or self._shown[0] != shown:
            self._shown = shown, drawn(shown.trainings, shown.others)
        return self._shown[1]

    def _told(self, done: int) -> "Told":
        """The results, read again when trainings have ended since; of loose recordings ``harness report`` tells."""
        if self._results[0] != done and isinstance(self._source, ExperimentSource):
            self._results = done, told_by(load_results(self._source.folder))
        return self._results[1]


def drawn(trainings: Sequence[Training], others: int) -> str:
    """The cards of trainings as HTML.

    Args:
        trainings: Those that are shown.
        others: How many are not.
    """
    return render_page(HERE / "live.html.j2", "The page", rows=rows_of(trainings), others=others)


@dataclass(frozen=True)
class Told:
    """What results tell a page.

    Attributes:
        answers: The comparisons so far, as HTML; empty before there is one.
        replay: Episodes of trainings that have ended; None before one has.
        title: The question.
    """

    answers: str
    replay: "Replay | None"
    title: str = ""

    @property
    def replay_part(self) -> str:
        """The replay and what it shows, as HTML."""
        return f"<p>{escape(self.replay.explanation)}</p>{self.replay.html}" if self.replay else ""


def told_by(results: Results) -> Told:
    """What results tell.

    Raises:
        UsageError: A library of the extra ``report`` is missing.
        SchemaError: A file is damaged or written by a newer version.
    """
    answers = render_page(HERE / "results.html.j2", "The page", answers=_answers(results))
    return Told(answers, replay_of(shows_of(results)), question(results))


def open_server(pages: Pages | CertificatePages, port: int) -> "ThreadingHTTPServer":
    """A server of `pages` on this machine alone.

    Raises:
        UsageError: The port is taken.
    """
    from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

    routes: dict[str, tuple[str, Callable[[], str]]] = {
        "/": ("text/html; charset=utf-8", pages.page),
        "/live": ("application/json", pages.live),
        "/results": ("application/json", pages.results),
    }

    class Server(ThreadingHTTPServer):
        """A server whose clients may leave at any time."""

        def handle_error(self, request: object, client_address: object) -> None:
            """Say in a line what nobody foresaw; a client that left, as a browser does, is foreseen."""
            error = sys.exception()
            if isinstance(error, Exception) and not isinstance(error, ConnectionError | TimeoutError):
                complain(describe_unexpected(error))

    class Handler(BaseHTTPRequestHandler):
        """Answers the addresses of the page."""

        timeout = PATIENCE

        def do_GET(self) -> None:
            """Answer with the page, or with what is new."""
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


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """Serve the page of an experiment beside a run that goes on in this process; gives the address.

    Raises:
        UsageError: No port is free.
    """
    with open_server(Pages(folder), 0) as server:
        thread = Thread(target=server.serve_forever, daemon=True)
        thread.start()
        try:
            yield address_of(server)
        finally:
            server.shutdown()
            thread.join()


def address_of(server: "ThreadingHTTPServer") -> str:
    """Where a browser finds it."""
    return f"http://{HOST}:{server.server_port}/"
