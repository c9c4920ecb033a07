"""What Unity sends, checked and made plain: behaviours, and what their agents ask and tell."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from harness import Float32

CONTINUOUS = 1
"""The kind of actions in messages of programs older than version 1.3 of the protocol."""


class UnityError(RuntimeError):
    """Unity sent what cannot be used, or nothing. The message says what, and what to do."""


class Behaviour(NamedTuple):
    """What all agents of a behaviour observe and do, as ML-Agents' Behavior Parameters say it."""

    name: str
    sizes: tuple[int, ...]
    """Numbers of each of its sensors."""
    sensors: tuple[str, ...]
    continuous: int
    """How many continuous actions."""
    branches: tuple[int, ...]
    """Choices of each discrete branch."""


class Told(NamedTuple):
    """What Unity says of one agent."""

    id: int
    observation: Float32
    """All sensors behind one another, (observation_size,)."""
    reward: float
    """Since the last message about the agent, that of its group included."""
    truncated: bool = False
    """Whether Max Step ended the agent's episode."""


@dataclass
class Message:
    """What Unity sent, by name of the behaviour.

    Attributes:
        asks: Agents that want an action, in Unity's order.
        ended: Agents whose episode ended.
    """

    asks: dict[str, list[Told]] = field(default_factory=dict)
    ended: dict[str, list[Told]] = field(default_factory=dict)


def behaviours_in(output: Any) -> Iterator[Behaviour]:
    """The behaviours that a message introduces; each comes once, with the first of its agents.

    Raises:
        UnityError: Algorithms cannot use its observations or its actions; says what to do in Unity.
    """
    for brain in output.rl_initialization_output.brain_parameters:
        agents = output.rl_output.agentInfos[brain.brain_name].value
        if agents:
            yield _behaviour(brain, agents[0])


def read_message(output: Any, behaviours: dict[str, Behaviour]) -> Message:
    """What is said of all agents whose behaviours are known.

    Raises:
        UnityError: An agent is there twice, or tells other numbers than its behaviour has, or none.
    """
    message = Message()
    for name, behaviour in behaviours.items():
        infos = output.rl_output.agentInfos[name].value if name in output.rl_output.agentInfos else ()
        message.ended[name] = [_told(info, behaviour) for info in infos if info.done]
        message.asks[name] = [_told(info, behaviour) for info in infos if not info.done]
        for said in (message.ended[name], message.asks[name]):
            _require_once(name, [told.id for told in said])
    return message


def _behaviour(brain: Any, agent: Any) -> Behaviour:
    name = brain.brain_name
    for number, sensor in enumerate(agent.observations):
        what = f"sensor {sensor.name or number} of the behaviour '{name}' has the shape {tuple(sensor.shape)}"
        if len(sensor.shape) == 3:
            raise UnityError(f"{what}, an image: take the camera or render texture sensor off the agent in Unity")
        if len(sensor.shape) != 1:
            raise UnityError(f"{what}, rows of varying number: only rows of fixed length can be used")
    actions = brain.action_spec
    continuous, branches = actions.num_continuous_actions, tuple(actions.discrete_branch_sizes)
    if not (continuous or branches):
        sizes = tuple(brain.vector_action_size_deprecated)
        is_continuous = brain.vector_action_space_type_deprecated == CONTINUOUS
        continuous, branches = (sum(sizes), ()) if is_continuous else (0, sizes)
    sizes = tuple(int(sensor.shape[0]) for sensor in agent.observations)
    if not sum(sizes):
        raise UnityError(f"agents of the behaviour '{name}' observe nothing: set Space Size in its Behavior Parameters")
    return Behaviour(name, sizes, tuple(sensor.name for sensor in agent.observations), continuous, branches)


def _told(info: Any, behaviour: Behaviour) -> Told:
    sizes = tuple(len(sensor.float_data.data) for sensor in info.observations)
    who = f"agent {info.id} of the behaviour '{behaviour.name}'"
    if sizes != behaviour.sizes:
        raise UnityError(
            f"{who} observes {_numbers(sizes)}, and {_numbers(behaviour.sizes)} before: in Unity, give all agents of a "
            "behaviour the same sensors, and observe as many numbers in each step"
        )
    observation = np.fromiter((x for sensor in info.observations for x in sensor.float_data.data), np.float32)
    reward = float(info.reward) + float(info.group_reward)
    if not np.isfinite(observation).all():
        place = int(np.flatnonzero(~np.isfinite(observation))[0])
        raise UnityError(f"{who} observes {observation[place]} at place {place}: find the division by 0 in Unity")
    if not math.isfinite(reward):
        raise UnityError(f"{who} is paid {reward}: find the division by 0 in what Unity's AddReward gets")
    return Told(int(info.id), observation, reward, bool(info.max_step_reached))


def _require_once(name: str, ids: Iterable[int]) -> None:
    seen: set[int] = set()
    for one in ids:
        if one in seen:
            raise UnityError(
                f"agent {one} of the behaviour '{name}' is twice in one message: it calls RequestDecision or "
                "EndEpisode twice in a step"
            )
        seen.add(one)


def _numbers(sizes: tuple[int, ...]) -> str:
    return f"{' + '.join(map(str, sizes)) or 0} numbers"
