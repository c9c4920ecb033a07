"""The hooks that a plugin may implement.

A plugin is a module that is quick to import and that an entry point of the group ``harness`` names. Each hook gets a
function ``register``. Its signature is the same for all kinds::

    register(name, target, *, summary, requires=(), extra=None, short="")

`name` is what users type; `target` is ``"module:attribute"`` and is imported only when something uses it; `summary` is
one line of ``harness describe``; `requires` names the modules that have to be importable, ``mujoco`` or, with its least
version, ``mujoco>=3.17``; `extra` is the extra of the distribution that brings them; `short` may be typed in place of
the name, and records have the name.
"""

from collections.abc import Iterable
from typing import Protocol

import pluggy

PROJECT = "harness"
hookspec = pluggy.HookspecMarker(PROJECT)
hookimpl = pluggy.HookimplMarker(PROJECT)


class Register(Protocol):
    """The function that every hook receives."""

    def __call__(
        self,
        name: str,
        target: str,
        *,
        summary: str,
        requires: Iterable[str] = (),
        extra: str | None = None,
        heading: str = "",
        short: str = "",
    ) -> None:
        """Announce `target` under `name`; raises ValueError for a malformed name or target.

        A command may say under which `heading` ``harness --all`` lists it.
        """


class Hooks:
    """One hook for each kind of plugin. Its docstring says what the target has to be."""

    @hookspec
    def register_simulators(self, register: Register) -> None:
        """Targets: a dataclass that is a `harness.simulator.Simulator`."""

    @hookspec
    def register_algorithms(self, register: Register) -> None:
        """Targets: a dataclass that is a `harness.algorithm.Algorithm`."""

    @hookspec
    def register_rewards(self, register: Register) -> None:
        """Targets: a frozen dataclass that is a `harness.reward.Reward`."""

    @hookspec
    def register_metrics(self, register: Register) -> None:
        """Targets: a frozen dataclass that is a `harness.log.Measure`."""

    @hookspec
    def register_robots(self, register: Register) -> None:
        """Targets: a `pathlib.Path`, the folder that holds ``robot.toml`` and the URDF."""

    @hookspec
    def register_descriptions(self, register: Register) -> None:
        """Targets: a frozen dataclass that is a `harness.robot.DescriptionFormat`."""

    @hookspec
    def register_tasks(self, register: Register) -> None:
        """Targets: a frozen dataclass that is a `harness.task.Task`."""

    @hookspec
    def register_environments(self, register: Register) -> None:
        """Targets: a frozen dataclass that is a `harness.environment.Environment`."""

    @hookspec
    def register_executors(self, register: Register) -> None:
        """Targets: a dataclass that is a `harness.executor.Executor`."""

    @hookspec
    def register_trackers(self, register: Register) -> None:
        """Targets: a frozen dataclass that is a `harness.executor.Tracker`."""

    @hookspec
    def register_logs(self, register: Register) -> None:
        """Targets: a frozen dataclass that is a `harness.log.LogFormat`."""

    @hookspec
    def register_screens(self, register: Register) -> None:
        """Targets: a frozen dataclass that is a `harness.executor.Screen`."""

    @hookspec
    def register_sections(self, register: Register) -> None:
        """Targets: a frozen dataclass that is a `harness.results.Section`, with the name of its command."""

    @hookspec
    def register_commands(self, register: Register) -> None:
        """Targets: a function that becomes ``harness NAME``; typer turns its typed parameters into options."""


NOUNS = {
    "simulators": "simulator",
    "algorithms": "algorithm",
    "rewards": "reward",
    "metrics": "metric",
    "robots": "robot",
    "descriptions": "description format",
    "tasks": "task",
    "environments": "environment",
    "executors": "executor",
    "trackers": "tracker",
    "logs": "log format",
    "screens": "screen",
    "sections": "section",
    "commands": "command",
}
"""Every kind of plugin, and the noun for one of it. Each kind has a hook, ``register_simulators`` and so on."""
KINDS = tuple(NOUNS)
WORDS = {kind: noun.partition(" ")[0] for kind, noun in NOUNS.items()}
"""The one word for a kind that users type, ``harness new-plugin log``, and that names its templates and its page."""
