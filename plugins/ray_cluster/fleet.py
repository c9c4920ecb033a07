"""Gives cells to the nodes of a cluster, and begins a cell again if its node is lost."""

import math
import shutil
import sys
import tempfile
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, NamedTuple

import ray
from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

from harness import load_registry
from harness.errors import UsageError, one_line, print_visible
from harness.executor import Cell, Event, Job, OnEvent, Part, add_parts, parts_of
from harness.experiment.installation import describe_installation, differences
from harness.record.folder import partial_folder, publish
from harness.registry.given import Given

from .node import Ended, Found, Slot, Told, look_around

LOOK_EVERY: Final = 2.0
"""Seconds from one look at the cluster to the next."""
ALONE_AFTER: Final = 10.0
"""Seconds without a usable node after which the user is told."""


@dataclass(eq=False)
class Node:
    """A node of the cluster.

    Attributes:
        id: Ray's id of the node.
        name: Host name and address, for messages.
        slots: How many cells it has room for, by its CPUs and GPUs.
        answer: Ray's reference to what the node will answer; None when it has answered.
        sees_folder: Whether it can write where the cells' folders have to be.
        refusal: Why it gets no cells; empty if it does.
        alive: Whether the cluster still has it.
    """

    id: str
    name: str
    slots: int
    answer: Any
    sees_folder: bool = False
    refusal: str = ""
    alive: bool = True

    @property
    def is_usable(self) -> bool:
        """Whether it gets cells."""
        return self.alive and self.answer is None and not self.refusal and self.slots > 0


@dataclass
class Nodes:
    """All nodes that were ever seen; new ones are asked what they have.

    Attributes:
        cells: The cells to run.
        folder: Where their folders have to be.
        cpus: CPUs that each cell reserves.
        gpus: GPUs that each cell reserves.
        plugins: Plugins that the user gave by hand.
        known: All nodes that were ever seen, by Ray's ids.
    """

    cells: Sequence[Cell]
    folder: Path
    cpus: float
    gpus: float
    plugins: Sequence[Given] = ()
    known: dict[str, Node] = field(default_factory=dict)
    _looked: float = -LOOK_EVERY
    _seen: float = field(default_factory=time.monotonic)
    """When there last was a usable node, or one that has not answered; infinite once the user was told of none."""

    def __post_init__(self) -> None:
        """Note what this machine has, and put a file into the folder. A node that finds it sees the folder."""
        alike = {tuple(cell.plugins.items()): cell for cell in self.cells}
        self._asked = [cell.to_json() for cell in alike.values()]
        self._here = describe_installation(alike.values(), load_registry(given=self.plugins))
        self._token = tempfile.NamedTemporaryFile(dir=self.folder, prefix=".", suffix=".token")  # noqa: SIM115

    def close(self) -> None:
        """Remove the file that was put into the folder."""
        self._token.close()

    def look(self, at_once: bool = False) -> None:
        """Look which nodes there are, every few seconds or `at_once`, and read the answers of those that were asked.

        Raises:
            UsageError: No node can be used, and none ever could.
        """
        if at_once or time.monotonic() - self._looked >= LOOK_EVERY:
            self._looked = time.monotonic()
            for told in ray.nodes():
                if told["NodeID"] in self.known:
                    self.known[told["NodeID"]].alive = told["Alive"]
                elif told["Alive"]:
                    self.known[told["NodeID"]] = self._ask(told)
        waiting = {node.answer: node for node in self.known.values() if node.answer is not None}
        for answer in ray.wait(list(waiting), num_returns=len(waiting), timeout=0)[0] if waiting else ():
            self._hear(waiting[answer])
        if all(node.refusal or not node.slots for node in self.known.values()):
            size = f"it has no room for {self.cpus:g} CPUs" + f" and {self.gpus:g} GPUs" * bool(self.gpus)
            told = "; ".join(f"{node.name}: {node.refusal or size}" for node in self.known.values())
            raise UsageError(f"No node of the Ray cluster can run these cells: {told}")
        self._tell_if_alone()

    def _tell_if_alone(self) -> None:
        """Say once that no node is left, so that nobody waits without knowing for what."""
        now = time.monotonic()
        if any(node.is_usable or node.answer is not None for node in self.known.values()):
            self._seen = now
        elif now - self._seen >= ALONE_AFTER:
            self._seen = math.inf
            print_visible(
                "harness: every node of the Ray cluster that can run these cells is lost. The run waits, and goes on "
                "when a node joins. Ctrl-C ends it: finished cells are kept, and the same command does the others",
                err=True,
            )

    def _ask(self, told: dict[str, Any]) -> Node:
        has = told["Resources"]
        rooms = [has.get(kind, 0.0) / needed for kind, needed in (("CPU", self.cpus), ("GPU", self.gpus)) if needed]
        here = NodeAffinitySchedulingStrategy(told["NodeID"], soft=False)
        task = ray.remote(look_around).options(num_cpus=0, scheduling_strategy=here, max_retries=1)
        name = f"{told['NodeManagerHostname']} ({told['NodeManagerAddress']})"
        return Node(told["NodeID"], name, int(min(rooms)), task.remote(self._asked, self._token.name, self.plugins))

    def _hear(self, node: Node) -> None:
        answer, node.answer = node.answer, None
        try:
            found: Found = ray.get(answer)
        except ray.exceptions.RayTaskError as error:  # what it raised there tells what is missing
            node.refusal = one_line(error.cause)
        except ray.exceptions.RayError as error:
            node.refusal = one_line(error)
        else:
            node.sees_folder = found.sees_folder
            node.refusal = ", ".join(differences(self._here, found.installed))
        if node.refusal:
            print_visible(f"harness: {one_line(f'node {node.name} gets no cells: {node.refusal}')}", err=True)


WAIT: Final = 0.5
"""Seconds to wait for news before looking at the cluster again."""
UNHEARD: Final = 16
"""The largest number of parts of a cell's files that wait to be fetched."""


class Needs(NamedTuple):
    """CPUs and GPUs that a cell reserves, how often it is begun again, and whether its files are fetched."""

    cpus: float
    gpus: float
    retries: int
    fetch: bool


@dataclass(eq=False)
class _Task:
    """A job that is not done yet."""

    job: Job
    losses: int = 0
    """How many nodes or processes were lost while they did it."""


@dataclass(eq=False)
class _Seat:
    """A slot on a node, as this process sees it. A `Slot` does one cell after the other."""

    node: Node
    slot: Any
    heard: Any
    """What to wait for: the reference that says that the slot is ready, or the stream of its news; None if idle."""
    task: _Task | None = None


class Fleet:
    """Does jobs on the nodes of the cluster to which this process belongs."""

    def __init__(self, jobs: Sequence[Job], needs: Needs, at_once: int, on_event: OnEvent) -> None:
        self._waiting = deque(_Task(job) for job in jobs)
        self._needs, self._at_once, self._on_event = needs, at_once, on_event
        folder = jobs[0].folder.parent
        folder.mkdir(parents=True, exist_ok=True)
        cells, plugins = [job.cell for job in jobs], jobs[0].options.plugins
        self._nodes = Nodes(cells, folder, needs.cpus, needs.gpus, plugins)
        self._seats: list[_Seat] = []

    def run(self) -> None:
        """Do all jobs.

        Raises:
            UsageError: No node of the cluster can do them.
        """
        try:
            while self._waiting or any(seat.task for seat in self._seats):
                self._nodes.look()
                self._take_seats()
                self._hand_out()
                self._listen()
        finally:
            for seat in self._seats:
                ray.kill(seat.slot)  # its worker process ends with it
            self._nodes.close()

    def _take_seats(self) -> None:
        """Open as many slots as there is work for, on the nodes with most room left."""
        work = len(self._waiting) + sum(seat.task is not None for seat in self._seats)
        while len(self._seats) < min(self._at_once, work):
            usable = [node for node in self._nodes.known.values() if node.is_usable]
            taken = {node: sum(seat.node is node for seat in self._seats) for node in usable}
            free = {node: node.slots - count for node, count in taken.items() if count < node.slots}
            if not free:
                return
            self._seats.append(self._seat_on(max(free, key=lambda node: free[node])))

    def _seat_on(self, node: Node) -> _Seat:
        options = {"num_cpus": self._needs.cpus, "num_gpus": self._needs.gpus}
        here = NodeAffinitySchedulingStrategy(node.id, soft=False)
        slot: Any = ray.remote(Slot).options(**options, scheduling_strategy=here).remote()
        return _Seat(node, slot, slot.ready.remote())

    def _hand_out(self) -> None:
        for seat in self._seats:
            if seat.heard is None and self._waiting:
                self._begin(seat, self._waiting.popleft())

    def _begin(self, seat: _Seat, task: _Task) -> None:
        job, seat.task = task.job, task
        partial = partial_folder(job.folder)
        partial.mkdir(parents=True, exist_ok=True)
        options = {"num_returns": "streaming", "_generator_backpressure_num_objects": UNHEARD}
        if self._sends(seat):
            shutil.rmtree(_arrivals(job.folder), ignore_errors=True)  # of a node that was lost while it sent
            left = list(parts_of(partial))
            seat.heard = seat.slot.do_and_send.options(**options).remote(job.to_json(), sys.argv, left)
        else:
            seat.heard = seat.slot.do.options(**options).remote(job.to_json(), sys.argv)
        if not task.losses:
            self._on_event(Event("started", job.cell))

    def _sends(self, seat: _Seat) -> bool:
        return self._needs.fetch or not seat.node.sees_folder

    def _listen(self) -> None:
        """Wait for news of slots and nodes, and deal with the news of slots."""
        speakers = {seat.heard: seat for seat in self._seats if seat.heard is not None}
        waited_for = list(speakers)
        if not waited_for:
            waited_for = [node.answer for node in self._nodes.known.values() if node.answer is not None]
        if not waited_for:  # no node is left; others may come
            time.sleep(WAIT)
            return
        first, others = ray.wait(waited_for, timeout=WAIT, fetch_local=False)
        more = ray.wait(others, num_returns=len(others), timeout=0, fetch_local=False)[0] if first and others else []
        for speaker in (*first, *more):
            if speaker in speakers:
                self._hear(speakers[speaker])

    def _hear(self, seat: _Seat) -> None:
        try:
            told = ray.get(next(seat.heard) if seat.task else seat.heard)
        except (ray.exceptions.RayError, StopIteration) as error:
            self._lose(seat, one_line(error))
            return
        if seat.task is None:
            seat.heard = None  # it is ready
        else:
            self._follow(seat, seat.task, told)

    def _follow(self, seat: _Seat, task: _Task, told: Told) -> None:
        job = task.job
        if isinstance(told, Ended):
            if self._sends(seat):
                _receive(job.folder, is_complete=not told.reason)
            if told.is_killed:
                return self._lose(seat, told.reason)
            seat.task = seat.heard = None
            self._on_event(Event("ended", job.cell, reason=told.reason))
        elif isinstance(told, Part):
            add_parts(_arrivals(job.folder), [told])
        else:
            self._on_event(Event("progress", job.cell, told.steps, scalars=told.scalars))

    def _lose(self, seat: _Seat, why: str) -> None:
        """Deal with a slot that was lost, or whose process was. Another slot does its cell, `retries` times at most."""
        self._seats.remove(seat)
        ray.kill(seat.slot)
        self._nodes.look(at_once=True)
        task = seat.task
        if task is None:
            return
        task.losses += 1
        if task.losses <= self._needs.retries:
            self._waiting.appendleft(task)
            return
        reason = f"lost {task.losses} times, the last time on node {seat.node.name}: {why}"
        self._on_event(Event("ended", task.job.cell, reason=reason))


def _arrivals(folder: Path) -> Path:
    """The folder for a cell's files while they come from a node."""
    return partial_folder(folder.with_name(f"{folder.name}.arrivals"))


def _receive(folder: Path, is_complete: bool) -> None:
    """Put a cell's files in place when all have come: in its partial folder, or if it is complete in its folder."""
    partial = partial_folder(folder)
    shutil.rmtree(partial)
    _arrivals(folder).rename(partial)
    if is_complete:
        publish(partial, folder)
