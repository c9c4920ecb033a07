"""What a run would do, and what one sees while it goes on: a line per cell, how far it is, what it learned so far."""

import math
import time
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

from rich.console import Console, ConsoleOptions, RenderResult
from rich.measure import Measurement
from rich.progress import Progress, ProgressColumn, Task, TaskID
from rich.table import Column
from rich.text import Text

from harness.executor import Event
from harness.record.cell import Cell
from harness.record.pace import Pace
from harness.record.progress import RETURN, SPEED, SUCCESS
from harness.report.tables.grid import Terminal
from harness.text import LONGEST_MESSAGE

if TYPE_CHECKING:
    from harness.experiment.foresee import Foreseen
    from harness.results.under_way import SoFar


HINT_EVERY = 30.0
"""How often a training is asked what it hints at, [s]. All of its rows are read then."""
LARGE = 1e9
"""The bytes of memory from which on they are told."""
UNITS = ("B", "KB", "MB", "GB", "TB")
SHOWN_SEEDS = LONGEST_MESSAGE // 10


def foreseen_lines(found: "Foreseen") -> Iterator[str]:
    """The plan: where, how many, what is not run and why, what is, and what it takes."""
    yield f"Folder: {found.folder} ({'new' if found.is_new else 'exists, the run goes on there'})"
    total = len(found.done) + len(found.to_do) + found.left + len(found.skipped)
    of_run = {"done": len(found.done), "to do": len(found.to_do)}
    counts = {**of_run, "not in this run": found.left, "skipped": len(found.skipped)}
    is_most = bool(found.looks) or found.is_choosing
    yield f"{'At most ' if is_most else ''}{total} cells: " + ", ".join(
        f"{count} {noun}" for noun, count in counts.items() if count
    )
    for reason, count in Counter(reason for _, reason in found.skipped).items():
        yield f"skipped: {count}: {reason}"
    if found.looks:
        yield _looks(found)
    if found.is_choosing:
        yield from _choosing(found)
    else:
        yield from (f"done: {line}" for line in _by_combination(found.done, lists_seeds=not found.looks))
        yield from (f"to do: {line}" for line in _by_combination(found.to_do, lists_seeds=not found.looks))
    if found.to_do:
        yield from _evaluations(found.to_do[0], found.horizon)
        yield f"Time: {_time(found)}"
        yield f"Disk: {f'not known: {found.unknown}' if found.bytes is None else _size(found.bytes)}"
        if found.memory >= LARGE:
            yield f"Memory: {_size(found.memory)}, {min(found.at_once, len(found.to_do))} at once, {found.basis}"
    yield "Nothing is written."


def _looks(found: "Foreseen") -> str:
    """When a run with looks asks for the answer. Of its cells, those at the end are the most that there can be."""
    first = found.looks[0] * len({replace(it, seed=0) for it in (*found.done, *found.to_do)})
    seeds = ", ".join(map(str, found.looks))
    return f"Looks: at {seeds} seeds of each. The first takes {first} cells. The run ends with the answer"


def _choosing(found: "Foreseen") -> Iterator[str]:
    """Who is trained, and how often: which cells these are is known when the worse half leaves."""
    yield f"Candidates: {', '.join(found.candidates)}"
    if found.schedule is None:
        yield "The first training of each tells how many there is time for"
        return
    rungs = ", ".join(
        f"{'the better ' * bool(at)}{rung.candidates} with {rung.seeds} training{'s' * (rung.seeds != 1)} each"
        for at, rung in enumerate(found.schedule.rungs)
    )
    yield f"In each place: {rungs}. Then {found.schedule.fresh} new ones of the one that is left, and of the baseline"


def _by_combination(cells: Sequence["Cell"], *, lists_seeds: bool) -> Iterator[str]:
    """A line for each simulator, algorithm and reward, with its seeds: which, or how many."""
    seeds: dict[str, list[int]] = {}
    for cell in cells:
        title = " · ".join((cell.place.label, cell.learner, cell.reward.label))
        seeds.setdefault(title, []).append(cell.seed)
    for title, these in seeds.items():
        if not lists_seeds:
            yield f"{title}: {len(these)} {'seed' if len(these) == 1 else 'seeds'}"
            continue
        shown = ", ".join(map(str, these[:SHOWN_SEEDS])) + (" ..." if len(these) > SHOWN_SEEDS else "")
        yield f"{title}: {'seed' if len(these) == 1 else f'{len(these)} seeds:'} {shown}"


def _evaluations(cell: "Cell", horizon: int) -> Iterator[str]:
    """How long episodes may be where nothing but an environment ends them: every cell of a run has the same horizon."""
    if cell.cut_after is not None:
        episodes = f"{cell.evaluation_episodes:,} episodes of each policy"
        is_own = 0 < horizon <= cell.cut_after
        most = (
            f"of at most {horizon:,} steps" if is_own else f"cut after {cell.cut_after:,} steps if it goes on so long"
        )
        yield f"Evaluations: {episodes}, each {most}"


def _time(found: "Foreseen") -> str:
    if found.seconds is None:
        return f"not known: {found.unknown}"
    most = "at most " if found.looks or found.is_choosing else ""
    return f"{most}{about(found.seconds)}, {min(found.at_once, len(found.to_do))} at once, {found.basis}"


def about(seconds: float) -> str:
    """A duration as text: ``about 40 s``, ``about 3 min``, ``about 2 h 10 min``."""
    return f"about {_rounded(seconds)}"


def left_text(seconds: float, *, at_most: bool = False) -> str:
    """The time that is left as text, ``about 3 min left``; where less may do, ``at most 3 min left``."""
    return f"{'at most' if at_most else 'about'} {_rounded(seconds)} left"


def _rounded(seconds: float) -> str:
    """To 5 seconds below 100 seconds, to minutes below 100 minutes, to 10 minutes below 10 hours."""
    if seconds < 9.5:
        return f"{max(round(seconds), 1)} s"
    if seconds < 97.5:
        return f"{5 * round(seconds / 5)} s"
    if seconds < 97.5 * 60:
        return f"{round(seconds / 60)} min"
    hours, tens = divmod(round(seconds / 600), 6)
    if hours >= 10:
        return f"{round(seconds / 3600)} h"
    return f"{hours} h {10 * tens} min" if tens else f"{hours} h"


def _size(count: float) -> str:
    """A size as text, ``about 1.2 MB``."""
    power = 0
    while count >= 1000.0 and power < len(UNITS) - 1:
        count, power = count / 1000.0, power + 1
    return f"about {count:.3g} {UNITS[power]}"


UNENDED_AFTER = 10_000
"""Environment steps without the end of an episode after which that is said; or all steps of a shorter training."""


def success_text(success: float | None) -> str:
    """The share of successes as text, ``success 64 %``; empty before an episode has ended."""
    return "" if success is None else f"success {100 * success:.0f} %"


def return_text(mean: float | None) -> str:
    """The mean return as text, ``return 31.2``, with up to eight characters; empty before an episode has ended."""
    if mean is None:
        return ""
    return f"return {mean:,.0f}" if 1e3 <= abs(mean) < 1e6 else f"return {mean:.3g}"


def unended_text(cell: "Cell", steps: int, mean: float | None) -> str:
    """A line if no episode of a training has ended, where only the environment ends them; empty before that is odd.

    Args:
        cell: Which training.
        steps: How many it has done.
        mean: What its last episodes were paid; None before one has ended.
    """
    is_odd = cell.cut_after is not None and mean is None and steps >= min(UNENDED_AFTER, cell.steps)
    return f"no episode has ended in {steps:,} steps of training" if is_odd else ""


WIDE = 76
"""Columns of a terminal that has room for the steps too."""
FIRST_AFTER, EVERY = 5.0, 60.0
"""Seconds without a terminal: from the first cell's start to the first word on the time left, and the longest silence
while cells tell how far they are."""
CELLS = "all cells"


class LiveProgress:
    """Call it with every event. Without a terminal it prints a line when a cell starts or ends."""

    def __init__(
        self,
        cells: Sequence[Cell],
        done: Collection[Cell],
        console: Console | None = None,
        log_of: Callable[[Cell], Path] | None = None,
        *,
        at_most: bool = False,
        now: Callable[[], float] = time.monotonic,
        so_far: "Callable[[Cell], SoFar | None] | None" = None,
    ) -> None:
        """Show nothing yet.

        Args:
            cells: All cells of the experiment that are asked for.
            done: Those of them that were done before.
            console: Where to show it.
            log_of: Where the log of a cell that failed is; None where there is none to look at.
            at_most: Whether the run may end before all cells have: where the answer stands.
            now: The time, [s].
            so_far: What is there of a training, asked every `HINT_EVERY` seconds; None where nobody looks.
        """
        self._log_of, self._at_most, self._now, self._so_far = log_of, at_most, now, so_far
        self._begun = self._printed = math.inf
        self._left_told = False
        self._has_one_reward = len({cell.reward.label for cell in cells}) == 1
        self._console = console or Terminal(stderr=True)
        # A cell has one line: what is too long for it is its name.
        self._progress = Progress(
            NameColumn(table_column=Column(ratio=1, no_wrap=True)),
            *(FieldColumn(field) for field in (_percent, self._done_so_far, _success, self._return, self._left)),
            console=self._console,
            expand=True,
        )
        ended = {cell.id for cell in done}
        to_do = [cell for cell in cells if cell.id not in ended]
        self._pace = Pace(to_do, now)
        steps = sum(cell.steps for cell in to_do)
        columns = list(zip(*map(_parts, cells), strict=True))
        differing = [index for index, column in enumerate(columns) if len(set(column)) > 1]
        self._parts = differing or list(range(len(columns)))  # those of a name that tell the cells apart
        self._overall = self._progress.add_task(CELLS, total=steps, short=CELLS, scalars={})
        self._tasks: dict[str, TaskID] = {}
        self._steps: dict[str, int] = {}
        self._scalars: dict[str, dict[str, float]] = {}
        self._started: dict[str, float] = {}
        self._total, self._ended = len(cells), len(done)
        self._failed: set[str] = set()
        self._warned: set[str] = set()
        self._looked, self._hints = dict[str, float](), dict[str, str]()
        if done:
            self._console.print(f"{len(done)} of {len(cells)} cells were done before and are not run again")

    def __enter__(self) -> "LiveProgress":
        if self._console.is_terminal and self._ended < self._total:
            self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        if self._progress.live.is_started:  # to stop what never started would print an empty line
            self._progress.stop()

    def __call__(self, event: Event) -> None:
        """Show an event."""
        show = {"started": self._start, "progress": self._advance, "ended": self._end}
        show[event.kind](event)
        if not self._console.is_terminal:
            self._tell_left()

    def warn(self, line: str) -> None:
        """Print a line above the others."""
        self._print(f"harness: {line}")

    def _start(self, event: Event) -> None:
        cell = event.cell
        if cell.id in self._failed:  # it is tried again
            self._failed.remove(cell.id)
            self._ended -= 1
        self._pace.start(cell)
        self._begun = min(self._begun, self._now())
        self._started[cell.id], self._steps[cell.id] = self._now(), 0
        scalars = self._scalars[cell.id] = dict[str, float]()
        name, short = (" ".join(parts) for parts in (_parts(cell), (_parts(cell)[index] for index in self._parts)))
        self._tasks[cell.id] = self._progress.add_task(name, total=cell.steps, short=short, scalars=scalars)
        if not self._console.is_terminal:
            self._print(f"{cell.title}: started")

    def _advance(self, event: Event) -> None:
        cell = event.cell
        self._pace.hear(cell, event.steps)
        self._scalars[cell.id].update(event.scalars)
        self._progress.update(self._tasks[cell.id], completed=event.steps)
        self._progress.advance(self._overall, event.steps - self._steps[cell.id])
        self._steps[cell.id] = event.steps
        if SPEED in event.scalars:  # with it comes the return, if an episode has ended
            self._warn_of_no_end(cell, event.steps)
        if self._so_far and self._now() - self._looked.get(cell.id, self._started[cell.id]) >= HINT_EVERY:
            self._looked[cell.id] = self._now()
            self._tell_hint(cell, self._so_far(cell))

    def _warn_of_no_end(self, cell: Cell, steps: int) -> None:
        """Say once that no episode of a training has ended, when that is odd."""
        told = unended_text(cell, steps, self._scalars[cell.id].get(RETURN))
        if told and cell.id not in self._warned:
            self._warned.add(cell.id)
            self.warn(f"{cell.title}: {told}")

    def _tell_hint(self, cell: Cell, told: "SoFar | None") -> None:
        """Say what a training hints at where nothing was said, and that it does so no more."""
        if told and bool(told.hint) != bool(self._hints.get(cell.id)):
            self._hints[cell.id] = told.hint
            self.warn(f"{cell.title}: {told.hint or 'What was hinted at holds no more.'}")

    def _end(self, event: Event) -> None:
        cell = event.cell
        self._ended += 1
        self._progress.remove_task(self._tasks.pop(cell.id))
        self._progress.advance(self._overall, cell.steps - self._steps.pop(cell.id))  # a failed cell is over too
        self._pace.end(cell, failed=bool(event.reason))
        seconds = max(self._now() - self._started.pop(cell.id), 1e-3)
        scalars = self._scalars.pop(cell.id)
        # Pay of several rewards has no common unit.
        mean = return_text(scalars.get(RETURN) if self._has_one_reward else None)
        told = (f"{seconds:.0f} s", f"{cell.steps / seconds:.0f} steps/s", success_text(scalars.get(SUCCESS)), mean)
        done = ", ".join(filter(None, told))
        outcome = self._failure(event) if event.reason else done
        note = f" ({event.note})" if event.note else ""
        left = f", {self._left_text}" if self._left_text and not self._console.is_terminal else ""
        self._print(f"[{self._ended}/{self._total}] {cell.title}: {outcome}{note}{left}")

    def _tell_left(self) -> None:
        """Without a terminal: say how long it takes yet, once it is known, and again after a silence."""
        now = self._now()
        if now < (self._printed + EVERY if self._left_told else self._begun + FIRST_AFTER):
            return
        text, to_do = self._left_text, self._total - self._ended
        if not text and now < self._printed + EVERY:
            return
        self._left_told = self._left_told or bool(text)
        trainings = f"{to_do} {'training' if to_do == 1 else 'trainings'}"
        self._print(f"{text or 'no step was measured yet'}: {trainings}, {min(self._pace.at_once, to_do)} at once")

    @property
    def _left_text(self) -> str:
        """How long the whole run takes yet, ``about 3 min left``; empty before that can be told, and at its end."""
        seconds = self._pace.left if self._ended < self._total else None
        return "" if seconds is None else left_text(seconds, at_most=self._at_most)

    def _failure(self, event: Event) -> str:
        self._failed.add(event.cell.id)
        log = f" Log: {self._log_of(event.cell)}" if self._log_of else ""
        return f"FAILED: {event.reason}.{log}"

    def _print(self, line: str) -> None:
        self._printed = self._now()
        self._progress.console.print(line, soft_wrap=True, markup=False, highlight=False)

    def _done_so_far(self, task: Task) -> str:
        """The steps of a cell, if there is room; of all cells, how many have ended."""
        if task.id == self._overall:
            return f"{self._ended}/{self._total}"
        return f"{task.completed:,.0f}/{task.total:,.0f}" if self._console.width >= WIDE else ""

    def _return(self, task: Task) -> str:
        """What episodes were paid; not where several rewards are trained, whose pay has no common unit."""
        return return_text(task.fields["scalars"].get(RETURN)) if self._has_one_reward else ""

    def _left(self, task: Task) -> str:
        """How long a cell takes yet; of all cells in words, where there is room."""
        if task.id != self._overall:
            return _clock(task.time_remaining)
        return (self._console.width >= WIDE and self._left_text) or _clock(self._pace.left)


class NameColumn(ProgressColumn):
    """What a line is about, cut in its middle where it is too long for what the other columns leave."""

    def render(self, task: Task) -> "Name":
        return Name(task.description, task.fields["short"])


@dataclass(frozen=True)
class Name:
    """A text that takes what room there is.

    Attributes:
        whole: Where there is room.
        short: Where there is less.
    """

    whole: str
    short: str

    def __rich_measure__(self, console: Console, options: ConsoleOptions) -> Measurement:
        return Measurement(1, len(self.whole))

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        room = options.max_width
        text = self.whole if len(self.whole) <= room else self.short
        if len(text) > room:
            end = (room - 1) // 2
            text = f"{text[: room - 1 - end]}…{text[len(text) - end :]}"
        yield Text(text, no_wrap=True, end="")


class FieldColumn(ProgressColumn):
    """A text that is made of the task, at the right."""

    def __init__(self, field: Callable[[Task], str]) -> None:
        super().__init__(Column(no_wrap=True, justify="right"))
        self._field = field

    def render(self, task: Task) -> Text:
        return Text(self._field(task), no_wrap=True)


def _percent(task: Task) -> str:
    return f"{int(task.percentage)} %"


def _success(task: Task) -> str:
    return success_text(task.fields["scalars"].get(SUCCESS))


def _clock(seconds: float | None) -> str:
    """The time that is left as text, ``1:02 left``."""
    if seconds is None:
        return "-:-- left"
    hours, minutes = divmod(int(seconds) // 60, 60)
    clock = f"{minutes}:{int(seconds) % 60:02}"
    return f"{hours}:{minutes:02} h left" if hours else f"{clock} left"


def _parts(cell: Cell) -> tuple[str, ...]:
    return cell.place.label, cell.learner, cell.reward.label, str(cell.seed)
