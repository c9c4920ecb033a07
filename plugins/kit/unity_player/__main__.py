"""The player as a program: it connects as Unity's players do, and says what their arms say."""

import argparse
import os
import sys
import time
import uuid
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import grpc
import numpy as np
from gymnasium.vector import AutoresetMode
from mlagents_envs.communicator_objects.command_pb2 import RESET
from mlagents_envs.communicator_objects.unity_message_pb2 import UnityMessageProto
from mlagents_envs.communicator_objects.unity_to_external_pb2_grpc import UnityToExternalProtoStub
from mlagents_envs.side_channel.incoming_message import IncomingMessage
from mlagents_envs.side_channel.side_channel import SideChannel
from mlagents_envs.side_channel.side_channel_manager import SideChannelManager

from harness import Float, Float32, load_robot
from harness.env.ideal import IdealSimulator
from harness.env.vector_env import ReachVectorEnv
from harness.registry import choose, load_registry

from . import write_unity_player

Acts = Literal["joints", "branches", "choice"]
TASK, ROBOT, REWARD = "unity-reach", "unity-arm", "baseline"
STRIDE = 0.1
"""How far a discrete action moves a joint, as a share of half its range."""


@dataclass(frozen=True)
class Said:
    """What one arm says after a decision.

    Attributes:
        id: The number of its episode, which Unity calls the agent's.
        observation: All that it observes.
        reward: Since it was last heard.
        done: Whether its episode ended.
        cut: Whether the longest time did that.
    """

    id: int
    observation: Float32
    reward: float = 0.0
    done: bool = False
    cut: bool = False


class Arms:
    """Arms in the task ``unity-reach``, paid by the reward ``baseline`` and the task's events."""

    def __init__(self, count: int, horizon: int, acts: Acts, shows_positions: bool, seed: int) -> None:
        """Put them up.

        Args:
            count: How many.
            horizon: Environment steps of an episode.
            acts: How they are moved: joint angles are set, a branch for each joint moves it, or one choice does.
            shows_positions: Whether the positions of end effector and target follow on what the baseline's agent
                observes.
            seed: Starts and targets are drawn with it.
        """
        registry = load_registry()
        task = choose(registry, "tasks", f"{TASK}:horizon={horizon}").build(registry, "tasks")
        reward = choose(registry, "rewards", REWARD).build(registry, "rewards")
        robot, off = load_robot(ROBOT, registry), AutoresetMode.DISABLED
        self._env = ReachVectorEnv(IdealSimulator(), robot, task, reward, count, autoreset_mode=off)
        self._acts, self._shows_positions, self._seed = acts, shows_positions, seed
        self._ids, self._next = [0] * count, 0
        self._set = np.zeros((count, self.joints), np.float32)

    @property
    def joints(self) -> int:
        """How many joints an arm has."""
        return self._env.robot.dof

    def reset(self, seed: int | None) -> list[Said]:
        """Begin an episode of every arm; the first reset without a seed has that of the start."""
        observations, _ = self._env.reset(seed=self._seed if seed is None else seed)
        self._set[:] = 0.0
        return [Said(self._number(k), row) for k, row in enumerate(self._shown(observations))]

    def decide(self, actions: dict[int, list[float]]) -> list[Said]:
        """Move every arm, by the action for its number; of one that ends, the next episode begins at once."""
        self._set[:] = [self._joints(actions.get(it), before) for it, before in zip(self._ids, self._set, strict=True)]
        observations, paid, terminated, truncated, _ = self._env.step(self._set.copy())
        ended, shown = terminated | truncated, self._shown(observations)
        said = [
            Said(self._ids[k], shown[k], float(paid[k]), bool(ended[k]), bool(truncated[k])) for k in range(len(shown))
        ]
        if ended.any():
            observations, _ = self._env.reset(options={"reset_mask": ended})
            shown, self._set[ended] = self._shown(observations), 0.0
            said += [Said(self._number(k), shown[k]) for k in np.flatnonzero(ended).tolist()]
        return said

    def _number(self, arm: int) -> int:
        self._ids[arm], self._next = self._next, self._next + 1
        return self._ids[arm]

    def _joints(self, action: list[float] | None, before: Float32) -> Float:
        if action is None:  # it did not ask
            return before.astype(np.float64)
        if self._acts == "joints":
            return np.clip(action, -1.0, 1.0)
        moves = np.zeros(self.joints)
        if self._acts == "branches":
            moves[:] = np.asarray(action) - 1.0
        elif action[0]:
            joint, is_down = divmod(int(action[0]) - 1, 2)
            moves[joint] = -1.0 if is_down else 1.0
        return np.clip(before + STRIDE * moves, -1.0, 1.0)

    def _shown(self, observations: Float32) -> Float32:
        episodes = self._env.episodes
        more = [episodes.end_effector, episodes.target] if self._shows_positions else []
        return np.hstack([observations, *more]).astype(np.float32)


PORT = "--mlagents-port"
GOOD, CRASHED = 200, 3
CHANNELS = {
    "parameters": uuid.UUID("534c891e-810f-11ea-a9d0-822485860400"),
    "engine": uuid.UUID("e951342c-4f7e-11ea-b238-784f4387d1f7"),
}
FAULTS = (
    *("crash", "hang", "silent", "old-version", "doubled", "nan", "nan-reward", "wrong-id", "shorter", "another-spec"),
    *("image", "both-actions", "gone"),
)
"""Mistakes that a program can make; most happen after `--fault-after` decisions."""


class Heard(SideChannel):  # type: ignore[misc] # mlagents_envs has no types
    """What came on a channel: the last number under each name."""

    def __init__(self, channel: uuid.UUID, named: bool) -> None:
        super().__init__(channel)
        self.numbers: dict[str, float] = {}
        self._named = named

    def on_message_received(self, msg: IncomingMessage) -> None:
        """Read a name or a number of what is set, the type of the value where there is a name, and the value."""
        name = msg.read_string() if self._named else str(msg.read_int32())
        if self._named:
            msg.read_int32()
        self.numbers[name] = msg.read_float32()


class Player:
    """The conversation of one player."""

    def __init__(self, options: argparse.Namespace) -> None:
        """Connect to nothing yet."""
        self._options = options
        self._parameters, self._engine = Heard(CHANNELS["parameters"], True), Heard(CHANNELS["engine"], False)
        self._channels = SideChannelManager([self._parameters, self._engine])
        self._is_known, self._decisions = False, 0
        self._arms: Arms
        self._asking: list[int] = []

    def play(self, exchange: Any) -> None:
        """Talk until the other side ends it."""
        options = self._options
        seed = self._greet(exchange)
        self._arms = Arms(options.agents, options.horizon, options.acts, options.positions, seed)
        answer = exchange(self._message())
        while answer.header.status == GOOD:
            given = answer.unity_input.rl_input
            self._channels.process_side_channel_message(given.side_channel)
            if given.command == RESET:
                said = self._arms.reset(self._seed())
            else:
                self._decisions += 1
                said = self._arms.decide(self._actions(given))
            answer = exchange(self._say(said))

    def _greet(self, exchange: Any) -> int:
        message = self._message()
        hello = message.unity_output.rl_initialization_output
        hello.name, hello.package_version = "harness", "2.0.0"
        hello.communication_version = "0.15.0" if self._options.fault == "old-version" else "1.5.0"
        hello.capabilities.baseRLCapabilities = hello.capabilities.hybridActions = True
        return int(exchange(message).unity_input.rl_initialization_input.seed)

    def _seed(self) -> int | None:
        told = self._parameters.numbers.pop("seed", None)
        return None if told is None else int(told)

    def _actions(self, given: Any) -> dict[int, list[float]]:
        """By number of the arm, in the order in which they asked."""
        actions = given.agent_actions[self._options.behavior].value
        if len(actions) != len(self._asking):
            raise SystemExit(f"{len(actions)} actions came for {len(self._asking)} agents")
        plain = [[*action.continuous_actions, *action.discrete_actions] for action in actions]
        return dict(zip(self._asking, plain, strict=True))

    def _message(self) -> Any:
        message = UnityMessageProto()
        message.header.status = GOOD
        message.unity_output.SetInParent()
        return message

    def _say(self, said: list[Said]) -> Any:
        message = self._message()
        is_due = self._decisions >= self._options.fault_after
        fault = self._options.fault if is_due else ""
        self._misbehave(fault)
        infos = message.unity_output.rl_output.agentInfos[self._options.behavior].value
        if fault == "gone":  # the first arm says nothing any more
            said = [one for one in said if one.id > 0]
        for one in said:
            self._put(infos.add(), one, fault)
        if fault == "doubled":
            infos.add().CopyFrom(infos[0])
        if not self._is_known or fault == "another-spec":
            self._introduce(message, fault)
        self._asking = [one.id for one in said if not one.done]
        return message

    def _misbehave(self, fault: str) -> None:
        if fault == "crash":
            sys.stdout.write("NullReferenceException: the arm is gone\n")
            sys.stdout.flush()
            os._exit(CRASHED)
        if fault == "hang":
            time.sleep(3600.0)

    def _put(self, info: Any, one: Said, fault: str) -> None:
        info.id, info.reward, info.done, info.max_step_reached = one.id, one.reward, one.done, one.cut
        numbers = one.observation.tolist()
        if fault == "shorter":
            numbers = numbers[:-1]
        if fault == "nan":
            numbers[2] = float("nan")
        if fault == "nan-reward":
            info.reward = float("nan")
        if fault == "wrong-id":
            info.id, info.done = 999, True
        sensor = info.observations.add()
        sensor.name, sensor.float_data.data[:] = "VectorSensor", numbers
        sensor.shape[:] = [8, 8, 3] if fault == "image" else [len(numbers)]

    def _introduce(self, message: Any, fault: str) -> None:
        brain = message.unity_output.rl_initialization_output.brain_parameters.add()
        brain.brain_name, self._is_known = self._options.behavior, True
        joints, acts = self._arms.joints, self._options.acts
        branches = {"joints": [], "branches": [3] * joints, "choice": [1 + 2 * joints]}[acts]
        brain.action_spec.num_continuous_actions = (joints if acts == "joints" else 0) + (fault == "another-spec")
        if fault == "both-actions":
            branches = [2]
        brain.action_spec.discrete_branch_sizes[:] = branches
        brain.action_spec.num_discrete_actions = len(branches)


def main(arguments: list[str]) -> int:
    """Play, or write a program that does; what Unity's players take besides is ignored."""
    options, _ = _parser().parse_known_args(arguments)
    if options.write:
        kept = [word for word in arguments if word not in ("--write", options.write)]
        sys.stdout.write(f"{write_unity_player(Path(options.write), kept).absolute()}\n")
        return 0
    if options.port is None:
        sys.stderr.write(f"{PORT} has to be given: whoever starts a player for a training gives it\n")
        return 2
    if options.fault == "silent":
        time.sleep(3600.0)
    with grpc.insecure_channel(f"127.0.0.1:{options.port}") as channel:
        stub = UnityToExternalProtoStub(channel)
        try:
            Player(options).play(stub.Exchange)
        except grpc.RpcError:  # the other side is gone
            return 0
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m harness_plugins.kit.unity_player", allow_abbrev=False)
    parser.add_argument("--write", metavar="PATH", help="write a program that starts the player so, and end")
    parser.add_argument(PORT, dest="port", type=int, help="where to connect")
    parser.add_argument("--behavior", default="Arm?team=0", help="the name of the behaviour")
    parser.add_argument("--agents", type=int, default=1, help="how many arms")
    parser.add_argument("--horizon", type=int, default=5000, help="environment steps of an episode")
    parser.add_argument("--acts", choices=("joints", "branches", "choice"), default="joints", help="kind of actions")
    parser.add_argument("--positions", action="store_true", help="observe end effector and target as well, 6 numbers")
    parser.add_argument("--fault", choices=FAULTS, help="make a mistake")
    parser.add_argument("--fault-after", type=int, default=0, metavar="N", help="after so many decisions")
    return parser


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
