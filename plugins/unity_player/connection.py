"""One player, or Unity's editor, and the protocol in which ML-Agents talks with it.

Unity is the client: this side listens, on this machine alone, and Unity connects. `mlagents_envs` has the protocol's
messages. Its own environment listens on all network interfaces and notices after seconds that a player died, so it is
not used here.
"""

import logging
from collections.abc import Mapping, Sequence
from pathlib import Path
from time import monotonic
from typing import Any

from .messages import Behaviour, Message, Told, UnityError, behaviours_in, read_message
from .process import PlayerProcess
from .protocol import (
    RESET,
    STEP,
    EngineConfigurationChannel,
    EnvironmentParametersChannel,
    SideChannelManager,
    UnityMessageProto,
    UnityRLCapabilitiesProto,
)
from .service import Service

PROTOCOL = "1.5.0"
"""The version of ML-Agents' protocol that is spoken; others with the same first number are understood."""
PACKAGE = "0.28.0"
GOOD, QUIT = 200, 400
"""What a message's header says: go on, or end."""
LOOK_EVERY = 0.2
"""Seconds between two looks whether a player that says nothing still runs."""
SEED = "seed"
"""The environment parameter that tells Unity the seed of what follows a reset."""
MOST_SEEDS = 2**24
"""Environment parameters are 32-bit floats: larger whole numbers would be rounded."""
Actions = Mapping[int, tuple[Sequence[float], Sequence[int]]]
"""By id of the agent: its continuous and its discrete actions."""


class Connection:
    """Unity, as it answers to resets and actions.

    Attributes:
        behaviours: By name, as far as Unity introduced them.
    """

    def __init__(
        self,
        program: Path | None,
        arguments: Sequence[str],
        *,
        port: int,
        seed: int,
        time_scale: float,
        patience: float,
    ) -> None:
        """Listen, start the player, and wait until it says hello.

        Args:
            program: The player; None waits for somebody to press Play in the editor.
            arguments: Given to the player.
            port: To listen on; 0 takes a free one.
            seed: Unity's random numbers begin with it.
            time_scale: How many times faster than in real time Unity's time goes.
            patience: Seconds to wait for any answer.

        Raises:
            UsageError: The port is taken.
            UnityError: Nothing connects, it ends, or it speaks another version.
        """
        self.behaviours: dict[str, Behaviour] = {}
        self._patience, self._is_open = patience, False
        self._asks: dict[str, list[Told]] = {}
        self._parameters, engine = EnvironmentParametersChannel(), EngineConfigurationChannel()
        self._channels = SideChannelManager([engine, self._parameters])
        engine.set_configuration_parameters(time_scale=time_scale)
        self._service = Service(port)
        self._player: PlayerProcess | None = None
        try:
            if program is not None:
                self._player = PlayerProcess(program, ["--mlagents-port", str(self._service.port), *arguments])
            else:
                logging.getLogger(__name__).warning(
                    "waiting on port %d: press Play in Unity's editor", self._service.port
                )
            self._greet(seed)
        except BaseException:
            self.close()
            raise

    def reset(self, seed: int | None) -> Message:
        """Begin anew, all agents.

        Args:
            seed: Sent as the environment parameter ``seed``; None sends none.
        """
        if seed is not None:
            self._parameters.set_float_parameter(SEED, float(seed % MOST_SEEDS))
        message = self._answer_to()
        message.unity_input.rl_input.command = RESET
        return self._exchange(message)

    def act(self, name: str, actions: Actions) -> Message:
        """Go on to the next message of Unity, which comes when an agent asks or ends.

        Args:
            name: Of the behaviour whose agents act.
            actions: Agents that asked and are not in it do nothing, 0, and so do those of other behaviours.
        """
        message = self._answer_to()
        step = message.unity_input.rl_input
        step.command = STEP
        for other, asks in self._asks.items():
            for told in asks:
                action = step.agent_actions[other].value.add()
                behaviour = self.behaviours[other]
                given = actions.get(told.id) if other == name else None
                continuous, discrete = given or ([0.0] * behaviour.continuous, [0] * len(behaviour.branches))
                action.continuous_actions.extend(continuous)
                action.discrete_actions.extend(discrete)
                action.vector_actions_deprecated.extend([*continuous, *discrete])
        return self._exchange(message)

    def close(self) -> None:
        """Tell Unity to end, and end the player."""
        if self._is_open:
            message = UnityMessageProto()
            message.header.status = QUIT
            self._service.answer(message)
            self._is_open = False
        if self._player is not None:
            self._player.end()
        self._service.stop()

    def _greet(self, seed: int) -> None:
        said = self._receive().unity_output.rl_initialization_output
        version = said.communication_version
        if version.partition(".")[0] != PROTOCOL.partition(".")[0]:
            raise UnityError(
                f"it speaks version {version or 'unknown'} of ML-Agents' protocol, and {PROTOCOL} is understood: build "
                "it with the package com.unity.ml-agents 1.0 to 3"
            )
        answer = self._answer_to()
        hello = answer.unity_input.rl_initialization_input
        hello.seed, hello.communication_version, hello.package_version, hello.num_areas = seed, PROTOCOL, PACKAGE, 1
        hello.capabilities.CopyFrom(
            UnityRLCapabilitiesProto(
                baseRLCapabilities=True, hybridActions=True, variableLengthObservation=True, multiAgentGroups=True
            )
        )
        self._service.answer(answer)
        self._is_open = True
        self._receive()

    def _answer_to(self) -> Any:
        message = UnityMessageProto()
        message.header.status = GOOD
        if self._is_open:
            message.unity_input.rl_input.side_channel = bytes(self._channels.generate_side_channel_messages())
        return message

    def _exchange(self, message: Any) -> Message:
        self._service.answer(message)
        output = self._receive().unity_output
        for behaviour in behaviours_in(output):
            if self.behaviours.setdefault(behaviour.name, behaviour) != behaviour:
                raise UnityError(
                    f"it introduces the behaviour '{behaviour.name}' again, with other observations or actions: give "
                    "each kind of agent a behaviour name of its own"
                )
        self._channels.process_side_channel_message(output.rl_output.side_channel)
        told = read_message(output, self.behaviours)
        self._asks = told.asks
        return told

    def _receive(self) -> Any:
        until = monotonic() + self._patience
        while (message := self._service.receive(LOOK_EVERY)) is None:
            if self._player is not None and (ending := self._player.ending()):
                self._is_open = False
                raise UnityError(f"the player ended ({ending})")
            if monotonic() > until:
                self._is_open = False
                raise UnityError(
                    f"it has said nothing for {self._patience:g} s. In Unity, Behavior Type has to be Default. A slow "
                    "program needs more: patience=SECONDS"
                )
        if message.header.status != GOOD and self._is_open:
            self._is_open = False
            raise UnityError("it ended the connection")
        return message
