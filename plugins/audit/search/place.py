"""What makes a world again, in another process or on another machine: names and numbers, never code."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from harness.authoring.commands import Choice


@dataclass(frozen=True)
class Place:
    """One reward in one task or environment.

    Attributes:
        task: The task of an arm, or the environment.
        reward: The reward.
        robot: The arm's name or path; empty in an environment.
        simulator: Whose engine moves the arm; None without one, and in an environment.
        success: What tells success, as a user types it; empty if nothing does.
        gamma: The learner's discount per step, in (0, 1].
        horizon: The most steps of an episode.
        plugins: What ``--plugin`` has to give: path and SHA-256 of files, names of classes.
    """

    task: Choice
    reward: Choice
    robot: str = ""
    simulator: Choice | None = None
    success: str = ""
    gamma: float = 0.99
    horizon: int = 0
    plugins: tuple[Mapping[str, Any], ...] = ()

    @property
    def is_environment(self) -> bool:
        """Whether it is an environment, and no task of an arm."""
        return not self.robot

    @property
    def name(self) -> str:
        """What it is called."""
        engine = f" in {self.simulator.label}" if self.simulator else ""
        return self.task.label if self.is_environment else f"{self.task.label}, {self.robot}{engine}"

    def to_json(self) -> dict[str, Any]:
        """Plain data; `from_json` gives the same back."""
        return {
            **vars(self),
            "task": self.task.to_json(),
            "reward": self.reward.to_json(),
            "simulator": self.simulator and self.simulator.to_json(),
            "plugins": [dict(need) for need in self.plugins],
        }

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> "Place":
        """What `to_json` told.

        Raises:
            ValueError: A name in it has several lines.
        """
        choices = {name: data[name] and Choice.from_json(data[name]) for name in ("task", "reward", "simulator")}
        return cls(**{**data, **choices, "plugins": tuple(data["plugins"])})
