"""The page of trainings in the browser, while they go on."""

import json
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import lru_cache, partial
from html import escape
from pathlib import Path
from typing import NamedTuple

from harness import load_results
from harness.errors import UsageError
from harness.record import Store
from harness.registry import load_registry
from harness.report import question, replay_of
from harness.report.facts import overview_grids
from harness.report.page.page import render_page
from harness.results.replay import shows_of

from .cards import rows_of
from .serving import Kept, serving
from .trainings import ExperimentSource, Training, source_of

HERE = Path(__file__).parent
SOON = 0.5
"""Seconds for which a page waits for its results; later it asks for them."""
REST = 4.0
"""Making results takes at most a fifth of the time: so many times as long they are kept."""
CERTIFICATES = "watch--certificates"
"""Under this name a plugin registers what makes the page of certificates."""


def pages_of(path: Path, is_live: bool = True) -> dict[str, Callable[[], str]]:
    """What makes each page, by its path: of an experiment, of recordings, or of certificates, which asks for nothing.

    Args:
        path: A folder, or one certificate.
        is_live: Whether the page asks for what is new; a file cannot.

    Raises:
        UsageError: The folder holds neither an experiment nor a recording.
    """
    registry = load_registry()
    if not Store.is_experiment(path) and CERTIFICATES in registry.names("commands"):
        page_in: Callable[[Path], str | None] = registry.get("commands", CERTIFICATES).load()

        def certificates() -> str:
            if (page := page_in(path)) is None:
                raise UsageError(f"'{path}' has no certificate any more")
            return page

        if page_in(path) is not None:
            return {"/": certificates}
    pages = Pages(path)
    return {"/": partial(pages.page, is_live), "/live": pages.live, "/results": pages.results}


class Told(NamedTuple):
    """What results tell a page.

    Attributes:
        done: How many trainings had ended; -1 before anything was read.
        title: The question, or before there is one what is shown.
        answers: The comparisons so far, as HTML; empty before there is one.
        html: The replay of trainings that have ended; empty before one has.
        style: Of the replay.
        script: Of the replay.
    """

    done: int
    title: str
    answers: str = ""
    html: str = ""
    style: str = ""
    script: str = ""


class Pages:
    """What there is to be served, one look for all who ask; results anew when trainings have ended since."""

    def __init__(self, folder: Path) -> None:
        """Read nothing yet.

        Raises:
            UsageError: The folder holds neither an experiment nor a recording.
        """
        source = source_of(folder)
        self._folder, self._look, self._results = folder, Kept(source.look), Kept(self._read, REST)
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
        trainings = drawn(shown.trainings, shown.others)
        return json.dumps({"news": news, "left": left, "trainings": trainings, "done": self._told.done})

    def results(self) -> str:
        """What follows from trainings that have ended, as JSON."""
        return json.dumps(self._results().result()._asdict())

    def page(self, is_live: bool) -> str:
        """The page as HTML.

        Args:
            is_live: Whether it asks for what is new, results that take longer than `SOON` too.

        Raises:
            HarnessError: The folder cannot be read.
        """
        shown = self._look().result()
        try:
            told = self._results().result(SOON if is_live else None)
        except TimeoutError:
            told = self._told
        trainings = drawn(shown.trainings, shown.others)
        return render_page(
            HERE / "watch.html.j2", "The page", told=told, shown=shown, trainings=trainings, is_live=is_live
        )

    def _read(self) -> Told:
        """The results, read again when trainings have ended since."""
        done = self._look().result().done
        if done != self._told.done:
            results = load_results(self._folder)
            compared = [it for it in results.combinations if it.seeds]
            grids = overview_grids(compared, with_intervals=True) if compared else []
            answers = render_page(HERE / "results.html.j2", "The page", grids=grids)
            replay = replay_of(shows_of(results)) or ()
            self._told = Told(done, question(results) or self._told.title, answers, *replay)
        return self._told


@lru_cache(maxsize=1)
def drawn(trainings: tuple[Training, ...], others: int) -> str:
    """The cards of trainings as HTML, drawn again when something is new.

    Args:
        trainings: Those that are shown.
        others: How many are not.
    """
    return render_page(HERE / "live.html.j2", "The page", rows=rows_of(trainings), others=others)


def served(folder: Path, port: int = 0) -> AbstractContextManager[str]:
    """Serve the pages of a folder, beside whatever goes on in this process; gives the address.

    Raises:
        HarnessError: The folder cannot be read, or the port is taken.
    """
    pages = pages_of(folder)
    pages["/"]()  # what is wrong with the folder is said here
    return serving(pages, port)
