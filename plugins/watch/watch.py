"""The page of trainings in the browser, while they go on."""

import json
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from harness.authoring.commands import line_names, overview_of, overview_row
from harness.authoring.pages import render_page
from harness.errors import UsageError
from harness.record import Store
from harness.registry import load_registry
from harness.report import question, replay_of
from harness.results import Results, load_results, shows_of

from .cards import rows_of
from .serving import Kept, serving
from .trainings import ExperimentSource, Shown, Training, source_of

if TYPE_CHECKING:
    from harness.authoring.pages import Replay

HERE = Path(__file__).parent
SOON = 0.5
"""Seconds for which a page waits for its results; later it asks for them."""
REST = 4.0
"""Making results takes at most a fifth of the time: so many times as long they are kept."""
CERTIFICATES = "watch--certificates"
"""Under this name a plugin registers what makes the page of certificates."""


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
    """What there is to be served, one look for all who ask; results anew when trainings have ended since."""

    def __init__(self, folder: Path) -> None:
        """Read nothing yet.

        Raises:
            UsageError: The folder holds neither an experiment nor a recording.
        """
        source = source_of(folder)
        self._folder, self._look, self._results = folder, Kept(source.look), Kept(self._read, REST)
        self._cards: tuple[tuple[tuple[Training, ...], int], str] = ((), 0), ""
        # Of loose recordings ``harness report`` tells.
        self._told = Told(-isinstance(source, ExperimentSource), f"Trainings in {folder.resolve().name}")

    def live(self) -> str:
        """What the page asks for every second, as JSON: the parts that are shown anew, by their names.

        And of how many trainings that ended there are results; newer ones are begun here.
        """
        shown = self._look().result()
        if shown.done != self._told.done:
            self._results()
        news, left = (escape(text) for text in (shown.news, shown.left))
        return json.dumps({"news": news, "left": left, "trainings": self._drawn(shown), "done": self._told.done})

    def results(self) -> str:
        """What follows from trainings that have ended, as JSON."""
        told = self._results().result()
        parts = {"done": told.done, "title": told.title, "answers": told.answers, "replay": told.replay_part}
        return json.dumps({**parts, **{name: getattr(told.replay, name, "") for name in ("script", "style")}})

    def page(self, is_live: bool = True) -> str:
        """The page as HTML.

        Args:
            is_live: Whether it asks for what is new, results that take longer than `SOON` too; a file cannot.

        Raises:
            HarnessError: The folder cannot be read.
        """
        shown = self._look().result()
        try:
            told = self._results().result(SOON if is_live else None)
        except TimeoutError:
            told = self._told
        return render_page(
            HERE / "watch.html.j2",
            "The page",
            told=told,
            shown=shown,
            trainings=self._drawn(shown),
            is_live=is_live,
        )

    def _drawn(self, shown: Shown) -> str:
        """The cards, drawn again when something is new."""
        there = shown.trainings, shown.others
        if self._cards[0] != there:
            self._cards = there, drawn(*there)
        return self._cards[1]

    def _read(self) -> "Told":
        """The results, read again when trainings have ended since."""
        done = self._look().result().done
        if done != self._told.done:
            self._told = told_by(load_results(self._folder), done, self._told.title)
        return self._told


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
        done: How many trainings had ended; -1 before anything was read.
        title: The question, or before there is one what is shown.
        answers: The comparisons so far, as HTML; empty before there is one.
        replay: Episodes of trainings that have ended; None before one has.
    """

    done: int
    title: str
    answers: str = ""
    replay: "Replay | None" = None

    @property
    def replay_part(self) -> str:
        """The replay and what it shows, as HTML."""
        return f"<p>{escape(self.replay.explanation)}</p>{self.replay.html}" if self.replay else ""


def told_by(results: Results, done: int, title: str) -> Told:
    """What results tell.

    Args:
        results: Of a folder.
        done: How many trainings had ended.
        title: Where there is no question.

    Raises:
        UsageError: A library of the extra ``report`` is missing.
        SchemaError: A file is damaged or written by a newer version.
    """
    answers = render_page(HERE / "results.html.j2", "The page", answers=_answers(results))
    return Told(done, question(results) or title, answers, replay_of(shows_of(results)))


def served(folder: Path, port: int = 0) -> AbstractContextManager[str]:
    """Serve the pages of a folder, beside whatever goes on in this process; gives the address.

    Raises:
        HarnessError: The folder cannot be read, or the port is taken.
    """
    pages = pages_of(folder)
    pages.page()  # what is wrong with the folder is said here
    routes = {
        "/": ("text/html", pages.page),
        "/live": ("application/json", pages.live),
        "/results": ("application/json", pages.results),
    }
    return serving(routes, port)


def _answers(results: Results) -> tuple[tuple[str, ...], list[tuple[str, ...]]] | None:
    """The comparisons so far: headings, and a row for each; None before there is one."""
    combinations = [it for it in results.combinations if it.seeds]
    if not combinations:
        return None
    overview, names = overview_of(combinations), line_names(combinations)
    rows = [overview_row(name, it, True, overview) for name, it in zip(names, combinations, strict=True)]
    return overview.headings, rows
