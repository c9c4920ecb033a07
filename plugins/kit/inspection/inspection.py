"""Has a plugin checked by another process, which may end, crash or never answer; each check comes to a finding."""

import itertools
import json
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import ClassVar, NamedTuple, TypeVar

from harness.errors import UsageError
from harness.executor import Limits
from harness.experiment.workers.order import Order, Report
from harness.experiment.workers.worker import print_into
from harness.experiment.workers.workers import Offspring, Pool
from harness.files.plain import from_plain, to_plain
from harness.record import partial_folder

from .ending import ending_in_words, place_in, split_output
from .finding import TARGET, Asked, Finding, Outline, PlannedCheck

Told = TypeVar("Told", Outline, Finding)
ANSWER, OUTPUT = "answer.json", "output.txt"
"""Files in an order's folder: the answer, and what the plugin printed. If the process crashed, its stack is there."""


@dataclass(frozen=True)
class TryPlugin:
    """Import and build a plugin, and run one check of it.

    Attributes:
        asked: What is checked.
        notes: Path of a file, see `harness_plugins.kit.inspection.subject.open_subject`.
        check: Name of the check, whose `Finding` is the answer. None: the plugin is only imported and built, and the
            answer is its `Outline`.
    """

    asked: Asked
    notes: str
    check: str | None = None

    noun: ClassVar[str] = "check"

    def do(self, folder: Path, report: Report) -> bool:
        partial = partial_folder(folder)
        print_into(partial / OUTPUT)
        (partial / ANSWER).write_text(json.dumps(to_plain(self._answer())), encoding="utf-8")
        os.rename(partial, folder)  # nobody needs it after a power cut, so the disk is not waited for
        return True

    def _answer(self) -> Outline | Finding:
        from .subject import open_subject, run_check

        subject = open_subject(self.asked, Path(self.notes))
        return subject.outline if self.check is None else run_check(subject, self.check)


def read_answer(kind: type[Told], folder: Path) -> Told | None:
    """The answer of an order: an `Outline`, or with a check a `Finding`; None if it left none."""
    try:
        told: Told = from_plain(kind, json.loads((folder / ANSWER).read_text(encoding="utf-8")))
    except (OSError, ValueError):  # a plugin may remove what is not its own, or double itself by a fork
        return None
    return told


OPENING_SECONDS = 40.0
"""How long a plugin may take to be imported and built: a learning library takes some seconds, from a slow disk more."""
MOST_PRINTED = 2**16
"""Bytes of what a plugin printed that are kept."""
NOTES, TEMPORARY = "notes.txt", "temporary"
"""In the folder of a workshop: what the process does at the moment, and the folder for its temporary files."""


class Loss(NamedTuple):
    """A process that left no answer.

    Attributes:
        sentence: What happened, and where if that is known.
        is_silent: Whether it did not answer in time, and was ended for that.
        seconds: What it took.
        story: The stack that Python wrote when the process ended; empty if it wrote none.
        printed: What the plugin printed.
    """

    sentence: str
    is_silent: bool = False
    seconds: float = 0.0
    story: str = ""
    printed: str = ""

    def finding(self, check: str, fact: str = "") -> Finding:
        """The finding of a check that ended so, which holds `fact`."""
        hint = "; --check-time allows more" if self.is_silent else ""
        rule = f". What has to hold: {fact}" if fact else ""
        return Finding(check, "error", f"{self.sentence}{hint}{rule}", self.seconds, self.story, self.printed)


@dataclass
class Workshop:
    """Tries one plugin; see `open_workshop`.

    Attributes:
        asked: What is tried.
        seconds: How long each answer may take; None: as long as usual.
        folder: For the answers.
        pool: Has the process.
        offspring: The process, and those that it started.
    """

    asked: Asked
    seconds: float | None
    folder: Path
    pool: Pool
    offspring: Offspring
    _is_open: bool = False
    _numbers: "itertools.count[int]" = field(default_factory=itertools.count)

    def open(self) -> Outline | Loss:
        """Have the plugin imported and built."""
        answer = self._ask(None, OPENING_SECONDS)
        if isinstance(answer, Loss):
            return answer._replace(sentence=f"{answer.sentence} while {self._doing()}")
        outline, printed = read_answer(Outline, answer), _tail_of(answer / OUTPUT)
        shutil.rmtree(answer, ignore_errors=True)
        if outline is None:
            return Loss("the import left no answer", printed=printed)
        self._is_open = True
        return replace(outline, findings=tuple(replace(finding, printed=printed) for finding in outline.findings))

    def run(self, check: PlannedCheck) -> Finding | Loss:
        """Have a check run, in a process where the plugin was imported and built before."""
        if not self._is_open and isinstance(opened := self.open(), Loss):
            return opened
        answer = self._ask(check.name, check.seconds)
        if isinstance(answer, Loss):
            return answer
        finding, printed = read_answer(Finding, answer), _tail_of(answer / OUTPUT)
        shutil.rmtree(answer, ignore_errors=True)
        return replace(finding, printed=printed) if finding else Loss("the check left no answer", printed=printed)

    def _ask(self, check: str | None, usual: float) -> Path | Loss:
        """Have the process do one thing; returns the folder that it leaves."""
        folder, limit, begun = self.folder / str(next(self._numbers)), self.seconds or usual, time.monotonic()
        order = Order(folder, TryPlugin(self.asked, str(self.folder / NOTES), check), Limits(cell_time=limit))
        *_, news = self.pool.run([order], at_once=1)
        if not news.reason:
            return folder
        self._is_open = False
        self.offspring.kill()
        printed, story = split_output(_tail_of(partial_folder(folder) / OUTPUT))
        what = f"no answer for {limit:g} s" if news.over_limit else ending_in_words(news.status or 0)
        where = f" ({place})" if (place := place_in(story)) else ""
        return Loss(what + where, news.over_limit, time.monotonic() - begun, story, printed)

    def _doing(self) -> str:
        try:
            return (self.folder / NOTES).read_text(encoding="utf-8")
        except OSError:
            return "the harness was imported"


@contextmanager
def open_workshop(asked: Asked, seconds: float | None) -> Iterator[Workshop]:
    """A workshop. When the block ends, however that is, none of its processes and none of their files are left."""
    offspring = Offspring()
    with tempfile.TemporaryDirectory(prefix="harness-check-", ignore_cleanup_errors=True) as folder:
        temporary = Path(folder) / TEMPORARY
        temporary.mkdir()
        environment = {**offspring.environment, **dict.fromkeys(("TMPDIR", "TEMP", "TMP"), str(temporary))}
        try:
            with Pool(environment) as pool, offspring.ended_at_once():
                yield Workshop(asked, seconds, Path(folder), pool, offspring)
        finally:
            offspring.kill()


def _tail_of(path: Path) -> str:
    """The end of a text file; empty if there is none."""
    try:
        with path.open("rb") as file:
            file.seek(max(0, file.seek(0, os.SEEK_END) - MOST_PRINTED))
            return file.read().decode("utf-8", errors="replace")
    except OSError:
        return ""


MOST_LOST, MOST_SILENT = 3, 2
"""After so many checks in a row in which the process ended, or did not answer in time, the rest is not run.

Those without an answer are fewer, since each takes all the time that it has.
"""


@dataclass
class Inspection:
    """The checks of one plugin, run one after the other.

    Attributes:
        asked: What is checked.
        long: Whether to run the checks that take minutes too.
        seconds: How long a check may take; None: as long as is usual for its kind.
        kind: ``rewards`` and so on, once the first finding is there; empty if the plugins could not be loaded.
    """

    asked: Asked
    long: bool = False
    seconds: float | None = None
    kind: str = field(default="", init=False)

    def findings(self) -> Iterator[Finding]:
        """Run the checks; each finding comes as soon as it is there.

        Raises:
            UsageError: The name is unknown, or its parameters cannot be.
        """
        with open_workshop(self.asked, self.seconds) as workshop:
            outline = workshop.open()
            if isinstance(outline, Loss):
                yield outline.finding(TARGET)
                return
            if outline.mistake:
                raise UsageError(outline.mistake)
            self.kind = outline.kind
            yield from outline.findings
            losses: list[Loss] = []
            for check in outline.checks:
                yield self._find(check, workshop, losses)

    def _find(self, check: PlannedCheck, workshop: Workshop, losses: list[Loss]) -> Finding:
        """Run a check unless there is a reason not to; keeps those that were lost in a row up to now in `losses`."""
        if check.long and not self.long:
            return Finding(check.name, "not run", "takes minutes: add --long")
        if reason := _why_no_more(losses):
            return Finding(check.name, "not run", reason)
        answer = workshop.run(check)
        if isinstance(answer, Loss):
            losses.append(answer)
            return answer.finding(check.name, check.fact)
        losses.clear()
        return answer


def _why_no_more(losses: list[Loss]) -> str:
    """Why no more checks are run after these were lost in a row; empty if there may be more."""
    if sum(loss.is_silent for loss in losses) >= MOST_SILENT:
        return f"{MOST_SILENT} checks in a row had no answer: mend that first"
    return f"{len(losses)} checks in a row ended the process: mend that first" if len(losses) >= MOST_LOST else ""
