"""One cell of the matrix: everything that decides what a training run does."""

import hashlib
import json
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Any, NamedTuple

from pydantic import Field, with_config

from harness.eta.manner import OWN_AND_OTHER, Manner
from harness.files.plain import Plain
from harness.record.file_forms import EXACT, Chosen, Count, Name, Whole
from harness.registry.choice import Choice


class Place(NamedTuple):
    """What moves in a cell."""

    simulator: Choice
    robot: str


BROUGHT = Place(Choice("(environment)", (), "environment"), "(environment)")
"""The place of a cell in an environment, which brings what moves there: no plugin can have these names."""
UNKNOWN_ALGORITHM = Choice("unknown", (), "unknown")
"""In place of the algorithm of a training that no experiment made: nobody recorded it."""
EVALUATION_HORIZON = 10_000
"""Environment steps after which an episode of an evaluation in an environment is cut: ten times what most allow."""
DISCOUNT = "gamma"
"""The parameter of an algorithm that people are told beside its name, of a cell in an environment."""
LATER = {"evaluate_every": 0, "deterministic": True, "evaluation_horizon": EVALUATION_HORIZON, "records": []}
"""Fields that the first version did not have. At these values they are left out, and ids stay what they were."""


@with_config(EXACT)
@dataclass(frozen=True)
class Cell(Plain):
    """One training run, to be done or done.

    Attributes:
        simulator: Whose engine moves the arm; that of `BROUGHT` where the task is an environment.
        robot: Registered name or folder of the arm; that of `BROUGHT` where the task is an environment.
        task: What the arm has to do, or an environment that trains; see `is_in_environment`.
        algorithm: What learns.
        reward: What it is paid for.
        seed: Of the starts, the targets and the algorithm. Equal seeds meet equal starts and targets, whatever the
            reward or the algorithm.
        steps: Environment steps of training.
        evaluation_episodes: Episodes of an evaluation; the same starts and targets in every cell.
        evaluate_every: Environment steps from one evaluation during training to the next; 0 for one at the end alone.
        deterministic: Whether evaluated policies take the one action of each observation, NOTE eq. 36, or draw.
        evaluation_horizon: In an environment: environment steps after which an episode of an evaluation is cut. A task
            of an arm has a horizon of its own.
        records: What its traces keep beside the usual columns, ``qvel``, because a reward or a measure of the
            experiment reads it; in an environment of an arm, its rewards that the experiment compares. It changes
            nothing of the training, and cells that differ in it alone are the same.
    """

    simulator: Chosen
    robot: Name
    task: Chosen
    algorithm: Chosen
    reward: Chosen
    seed: Whole
    steps: Count
    evaluation_episodes: Count
    evaluate_every: Whole = 0
    deterministic: bool = True
    evaluation_horizon: Count = EVALUATION_HORIZON
    records: Annotated[tuple[Name, ...], Field(max_length=1_000)] = field(default=(), compare=False)

    @cached_property
    def id(self) -> str:
        """A hash of the content, but for `records`."""
        content = {key: value for key, value in self.to_json().items() if key != "records"}
        text = json.dumps(content, sort_keys=True, separators=(",", ":"))
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    @property
    def is_in_environment(self) -> bool:
        """Whether the task is a `harness.environment.Environment`, and the reward one of those that it names."""
        return self.simulator == BROUGHT.simulator

    @property
    def place(self) -> Choice:
        """Where it trains, for people: the simulator, or the environment."""
        return self.task if self.is_in_environment else self.simulator

    @property
    def floor(self) -> tuple[Any, ...]:
        """All that decides what random actions do in an evaluation, but for what they are paid."""
        return self.simulator, self.robot, self.task, self.evaluation_episodes, self.evaluation_horizon

    @property
    def acted(self) -> Manner:
        """How evaluated policies act."""
        return OWN_AND_OTHER[self.deterministic][0]

    @property
    def cut_after(self) -> int | None:
        """Steps after which an episode of an evaluation is cut; None where the task has a horizon of its own."""
        return self.evaluation_horizon if self.is_in_environment else None

    @property
    def learner(self) -> str:
        """For people: the algorithm; in an environment with its discount, though that may be a default."""
        return self.algorithm.label_with(DISCOUNT) if self.is_in_environment else self.algorithm.label

    @property
    def title(self) -> str:
        """For people: the combination and the seed."""
        return f"{self.place.label} · {self.learner} · {self.reward.label} · seed {self.seed}"

    @property
    def plugins(self) -> dict[str, str]:
        """Names of the plugins that it chooses, by kind, as manifests name their sources; a robot may be a path."""
        if self.is_in_environment:
            return {"environments": self.task.name, "algorithms": self.algorithm.name}
        return {
            "simulators": self.simulator.name,
            "tasks": self.task.name,
            "algorithms": self.algorithm.name,
            "rewards": self.reward.name,
            "robots": self.robot,
        }

    @property
    def drives_with_servo(self) -> bool:
        """Whether the drives of the robot's robot.toml move the arm: their numbers decide the result then."""
        return dict(self.simulator.params).get("drive") == "servo"

    def to_json(self) -> dict[str, Any]:
        """Plain data; `from_json` gives the same cell back."""
        return {key: value for key, value in super().to_json().items() if not (key in LATER and value == LATER[key])}
