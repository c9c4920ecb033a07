"""The nodes of a cluster: which of them have what the cells need."""

import math
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import ray
from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

from harness.errors import UsageError, one_line
from harness.experiment.installation import describe_installation, differences
from harness.record.cell import Cell
from harness.registry.given import Given, given_to_json
from harness.registry.registry import load_registry
from harness.text import one_line_of, print_visible

from .node import Found, look_around

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
        alike = {(*(choice.name for choice in _choices(cell)), cell.robot): cell for cell in self.cells}
        self._asked = [cell.to_json() for cell in alike.values()]
        self._here = describe_installation(alike.values(), load_registry(given=self.plugins))
        self._token = tempfile.NamedTemporaryFile(dir=self.folder, prefix=".", suffix=".token")  # noqa: SIM115

    def close(self) -> None:
        """Remove the file that was put into the folder."""
        self._token.close()

    @property
    def usable(self) -> list[Node]:
        """The nodes that get cells."""
        return [node for node in self.known.values() if node.is_usable]

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
            raise UsageError(f"No node of the Ray cluster can run these cells: {'; '.join(self._complaints())}")

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
        given = given_to_json(self.plugins)
        name = f"{told['NodeManagerHostname']} ({told['NodeManagerAddress']})"
        return Node(told["NodeID"], name, int(min(rooms)), task.remote(self._asked, self._token.name, given))

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
            print_visible(f"harness: {one_line_of(f'node {node.name} gets no cells: {node.refusal}')}", err=True)

    def _complaints(self) -> list[str]:
        size = f"it has no room for {self.cpus:g} CPUs" + f" and {self.gpus:g} GPUs" * bool(self.gpus)
        return [f"{node.name}: {node.refusal or size}" for node in self.known.values()]


def _choices(cell: Cell) -> tuple[Any, ...]:
    return (cell.simulator, cell.task, cell.algorithm, cell.reward)
