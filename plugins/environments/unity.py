"""A program that was built with Unity's ML-Agents, or Unity's editor."""

import importlib
import math
from collections.abc import Mapping
from functools import cached_property
from importlib.metadata import version
from typing import Annotated, Any, ClassVar, NamedTuple, Self

import numpy as np
from pydantic import Field, ValidationInfo, model_validator
from pydantic.dataclasses import dataclass

from harness import load_registry
from harness.environment import AnyEnv
from harness.errors import UsageError
from harness.files import require_program
from harness.registry.choice import build_defaults
from harness.reward import Given, ObservedReward, Reward
from harness.score.places import RENEWED, ArmPlaces, parse_places

OWN = "own"
DISTANCES = ("begin_distance", "closest_distance", "final_distance")
EDITOR_PORT = 5004
"""Where Unity's editor connects."""


class KnownPlaces(NamedTuple):
    """What is known of an agent that was published."""

    places: str
    own_pays: str
    steps: int


KNOWN = {"unity-arm": KnownPlaces("distance=17:18,renewed=8:11", "baseline", 5)}
"""``unity-arm`` is the agent of the baseline's public project: 19 numbers, of which the 18th is the distance to the
target, and those from the 9th to the 11th are the target's direction."""


@dataclass(frozen=True)
class Unity:
    """A program that was built with Unity's ML-Agents, or Unity's editor: its agents are trained as any robot is.

    Unity sends observations and rewards when an agent asks for a decision; its reward is `own`. If `places` says where
    the observation tells end effector and target, rewards of the FD100's tasks pay the same steps too, and success and
    distance are measured. `unity-arm` names the places of the baseline's published agent.

    Without `file` the environment waits until somebody presses Play in Unity's editor. Physics in Unity is not the same
    twice. So two runs with one seed are not equal, as they are in the simulators here.
    """

    file: Annotated[
        str, Field(description="path of the program; empty waits for Unity's editor to connect, see port")
    ] = ""
    behavior: Annotated[str, Field(description="Behavior Name of the agents, needed where the program has several")] = (
        ""
    )
    places: Annotated[
        str,
        Field(
            description="where observations tell positions, (end_effector=0:3,target=3:6), or distance=17:18; "
            f"or the name of a published agent: {', '.join(KNOWN)}"
        ),
    ] = ""
    pays: Annotated[
        str, Field(description="rewards of an arm that pay besides own where places are given, joined by +")
    ] = "baseline+arp+aarp"
    own_pays: Annotated[
        str,
        Field(
            description="the reward of an arm that is part of own: what own pays beyond it, such as a penalty for the "
            "ground, is added to the rewards in pays"
        ),
    ] = ""
    steps: Annotated[
        int, Field(ge=0, le=1_000, description="steps of the task in a decision, each of which pays; 0: 1, or as known")
    ] = 0
    reached: Annotated[
        float, Field(ge=0, description="distance within which the target counts as reached; 0: a new one is drawn [m]")
    ] = 0.0
    time_scale: Annotated[float, Field(gt=0, le=100, description="how many times faster than real time it runs")] = 20.0
    graphics: Annotated[bool, Field(description="whether the program opens a window")] = False
    port: Annotated[
        int, Field(ge=0, le=65_535, description=f"port to listen on; 0: a free one, for the editor {EDITOR_PORT}")
    ] = 0
    patience: Annotated[float, Field(gt=0, le=3_600, description="time to wait for any answer [s]")] = 60.0

    baseline: ClassVar[str] = OWN

    @model_validator(mode="after")
    def _build_what_is_named(self, info: ValidationInfo) -> Self:
        """See that places and rewards are known, before any program is started."""
        if self.places:
            registry = (info.context or {}).get("registry") or load_registry()
            named = [*self._known.own_pays.split(), *filter(None, self.pays.split("+"))]
            object.__setattr__(self, "_rewards", build_defaults(registry, "rewards", dict.fromkeys(named)))
            _ = self._observed
        return self

    @staticmethod
    def examples() -> Mapping[str, tuple[str, ...]]:
        """See `harness.environment.examples_of`: it needs a program, and none comes with the harness."""
        return {}

    @property
    def lower_is_better(self) -> frozenset[str]:
        """See `harness.environment.lower_is_better`."""
        return frozenset(DISTANCES) if self.places else frozenset()

    @property
    def higher_is_better(self) -> frozenset[str]:
        """See `harness.environment.lower_is_better`."""
        return frozenset({"targets"} if self.places and RENEWED in self._observed.places else ())

    @property
    def bounds(self) -> Mapping[str, tuple[float, float]]:
        targets = ("targets",) if self.places and (RENEWED in self._observed.places) else ()
        return dict.fromkeys((*DISTANCES, *targets) if self.places else (), (0.0, math.inf))

    def make(self) -> AnyEnv:
        return self.make_together(1)[0]

    def make_together(self, count: int) -> list[AnyEnv]:
        """See `harness.environment.envs_together`: agents of one program; of several if one has not enough."""
        if self.file:
            require_program(self.file, f"file={self.file}")
        agent_env, team = _import("agent_env"), _import("team")
        errors = _import("messages").UnityError
        envs, teams = list[AnyEnv](), list[Any]()
        try:
            while len(envs) < count:
                one = team.Team(self._connect, self.behavior, self.patience, restarts=bool(self.file))
                teams.append(one)
                if self.places:
                    _require_within(self._observed, sum(one.behaviour.sizes))
                envs += [agent_env.AgentEnv(one, place) for place in range(min(one.size, count - len(envs)))]
        except BaseException as error:
            for one in teams:
                one.end()
            if isinstance(error, errors):
                raise UsageError(f"Unity ({self.file or 'the editor'}): {error}") from error
            raise
        return envs

    def rewards(self, env: AnyEnv) -> Mapping[str, Given]:
        if not self.places:
            return {OWN: OWN}
        names = dict.fromkeys(filter(None, self.pays.split("+")))
        return {OWN: OWN, **{name: self._paid_by(name) for name in names}}

    def behaviour(self, env: AnyEnv) -> Mapping[str, Given]:
        if not self.places:
            return {}
        measures: dict[str, Given] = {}
        if self.reached or (RENEWED in self._observed.places):
            measures["success"] = Followed(self._observed, lambda it: float(it.targets > 0 or it.best <= self.reached))
        if RENEWED in self._observed.places:
            measures["targets"] = Followed(self._observed, lambda it: float(it.targets))
        measures["closest_distance"] = Followed(self._observed, lambda it: it.best)
        measures["begin_distance"] = Followed(self._observed, lambda it: it.begin)
        measures["final_distance"] = Followed(self._observed, lambda it: it.last)
        return measures

    @property
    def _known(self) -> KnownPlaces:
        known = KNOWN.get(self.places, KnownPlaces(self.places, "", 1))
        return KnownPlaces(known.places, self.own_pays or known.own_pays, self.steps or known.steps)

    @cached_property
    def _observed(self) -> ArmPlaces:
        return parse_places(self._known.places)

    def _paid_by(self, name: str) -> Given:
        rewards: Mapping[str, Reward] = vars(self)["_rewards"]
        _, own_pays, steps = self._known
        paid = ObservedReward(rewards[name], self._observed, steps)
        return WithEvents(paid, ObservedReward(rewards[own_pays], self._observed, steps)) if own_pays else paid

    def _connect(self, seed: int) -> Any:
        connection, process = _import("connection"), _import("process")
        program = process.find_program(self.file) if self.file else None
        arguments = [*(() if self.graphics else ("-nographics", "-batchmode")), "-logFile", "-"]
        port = self.port or (0 if self.file else EDITOR_PORT)
        return connection.Connection(
            program, arguments, port=port, seed=seed, time_scale=self.time_scale, patience=self.patience
        )


class Followed:
    """A number of an episode's distances and targets so far.

    Attributes:
        begin: The distance at the episode's start, or to the newest target when it was drawn, as seen before the step,
            [m]. With it a recording has all that the rewards of an arm are functions of.
        best: The smallest distance, [m].
        last: The last one, to the target of that step, [m].
        targets: How many targets were touched, so that a new one was drawn.
    """

    def __init__(self, places: ArmPlaces, value: Any) -> None:
        self._places, self._value = places, value
        self.reset()

    def reset(self) -> None:
        """An episode starts."""
        self.begin, self.best, self.last, self.targets = math.inf, math.inf, math.inf, 0
        self._is_new = True

    def __call__(self, observation: Any, action: Any, next_observation: Any, info: Any) -> float:
        """The number after one more step."""
        before, after = np.asarray(observation)[None], np.asarray(next_observation)[None]
        if self._is_new:
            self.begin = float(self._places.distances(before)[0])
        is_new = self._is_new = bool(self._places.has_new_target(before, after)[0])
        self.last = float((self._places.reached(before, after) if is_new else self._places.distances(after))[0])
        self.best, self.targets = min(self.best, self.last), self.targets + is_new
        return float(self._value(self))


class WithEvents:
    """A reward of an arm, and what the program pays beyond the arm's reward that is part of its own."""

    def __init__(self, reward: ObservedReward, part_of_own: ObservedReward) -> None:
        self._reward, self._part_of_own = reward, part_of_own

    def reset(self) -> None:
        """An episode starts."""
        self._reward.reset()
        self._part_of_own.reset()

    def __call__(self, observation: Any, action: Any, next_observation: Any, info: Any) -> float:
        """What the step pays."""
        step = (observation, action, next_observation, info)
        return self._reward(*step) + float(info["paid"]) - self._part_of_own(*step)


def _require_within(places: ArmPlaces, size: int) -> None:
    """See that an observation of so many numbers has all places."""
    try:
        places.distances(np.zeros((1, size)))
        places.has_new_target(np.zeros((1, size)), np.zeros((1, size)))
    except UsageError as error:
        raise UsageError(f"places: {error}") from error


def _import(module: str) -> Any:
    """A module that needs `mlagents_envs`, whose messages only an old protobuf can read.

    Raises:
        UsageError: The protobuf that is installed cannot.
    """
    try:
        return importlib.import_module(f"harness_plugins.unity_player.{module}")
    except TypeError as error:  # what protobuf raises for messages that an old one generated
        raise UsageError(
            f"mlagents-envs works with protobuf 3.20.3, and {version('protobuf')} is installed, which other packages "
            "need. Make an environment for Unity alone: pip install 'fd100-harness[unity]'"
        ) from error
