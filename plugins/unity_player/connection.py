"""One player, or Unity's editor, and the protocol in which ML-Agents talks with it.

Unity is the client: this side listens, on this machine alone, and Unity connects. `mlagents_envs` has the protocol's
messages. Its own environment listens on all network interfaces and notices after seconds that a player died, so it is
not used here.
"""

import logging
import os
import queue
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, Future
from contextlib import suppress
from pathlib import Path
from time import monotonic
from typing import Any

import grpc

from harness.errors import UsageError

from .messages import Behaviour, Message, Told, UnityError, behaviours_in, read_message
from .protocol import (
    RESET,
    STEP,
    EngineConfigurationChannel,
    EnvironmentParametersChannel,
    SideChannelManager,
    UnityMessageProto,
    UnityRLCapabilitiesProto,
    UnityToExternalProtoServicer,
    add_UnityToExternalProtoServicer_to_server,
)

HOST = "127.0.0.1"
"""Other machines cannot connect: whoever connects is believed to be Unity."""
THREADS = 2


class Service(UnityToExternalProtoServicer):  # type: ignore[misc] # generated code has no types
    """Takes one message of Unity after the other, and answers each with the next answer.

    Attributes:
        port: Where it listens.
    """

    def __init__(self, port: int) -> None:
        """Listen on this machine alone.

        Args:
            port: 0 takes a free one.

        Raises:
            UsageError: The port is taken.
        """
        self._said: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._answers: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._server = grpc.server(DaemonThreads(THREADS), options=(("grpc.so_reuseport", 0),))
        add_UnityToExternalProtoServicer_to_server(self, self._server)
        try:
            self.port = self._server.add_insecure_port(f"{HOST}:{port}")
        except RuntimeError as error:
            raise UsageError(
                f"port={port} is taken on this machine. Unity's editor has one connection: give --jobs 1, or another "
                "port"
            ) from error
        self._server.start()

    def Exchange(self, request: Any, context: Any) -> Any:  # noqa: N802 # the protocol's name
        """Unity says `request`; returns what it is answered."""
        self._said.put(request)
        return self._answers.get()

    def receive(self, seconds: float) -> Any:
        """What Unity says next; None if it says nothing for so long."""
        try:
            return self._said.get(timeout=seconds)
        except queue.Empty:
            return None

    def answer(self, message: Any) -> None:
        """Answer what Unity said last."""
        self._answers.put(message)

    def stop(self) -> None:
        """Listen no more."""
        self._server.stop(None)


class DaemonThreads(Executor):
    """Threads that no process waits for when it ends: they may wait for an answer that does not come any more."""

    def __init__(self, count: int) -> None:
        """Start them."""
        self._work: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        for _ in range(count):
            threading.Thread(target=self._run, daemon=True).start()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        """Have one of them call a function."""
        future: Future[Any] = Future()

        def call() -> None:
            try:
                future.set_result(fn(*args, **kwargs))
            except BaseException as error:  # the future tells who asked
                future.set_exception(error)

        self._work.put(call)
        return future

    def _run(self) -> None:
        while True:
            self._work.get()()


GUARD = Path(__file__).with_name("guard.py")
ENDINGS = {"linux": (".x86_64", ".x86", ""), "darwin": ("",), "win32": (".exe", "")}
"""What a built program's name may end with where a user leaves it out."""
LONGEST = 5.0
"""Seconds that a player gets to end by itself."""
SHOWN = 200
"""Characters of a player's last line that a message quotes."""


class PlayerProcess:
    """A player that runs. It ends with this process, however this process ends."""

    def __init__(self, program: Path, arguments: Sequence[str]) -> None:
        """Start it.

        Raises:
            UsageError: The system does not start it.
        """
        self._output = tempfile.TemporaryFile()  # noqa: SIM115 # closed in `end`
        command = [sys.executable, "-S", "-E", str(GUARD), str(program), *arguments]
        self._guard = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=self._output, stderr=subprocess.STDOUT)

    def ending(self) -> str:
        """How it ended, with its last line; empty while it runs."""
        code = self._guard.poll()
        if code is None:
            return ""
        told = f"exit status {code}" if code < 128 else f"signal {code - 128}"
        line = self._last_line()
        return f"{told}; its last line: {line}" if line else told

    def end(self) -> None:
        """End it, at once if it does not end by itself."""
        try:
            with suppress(subprocess.TimeoutExpired):  # it gets no more time
                self._guard.wait(LONGEST)
        finally:
            if self._guard.stdin:
                self._guard.stdin.close()
            self._guard.wait()
            self._output.close()

    def _last_line(self) -> str:
        self._output.seek(0, os.SEEK_END)
        self._output.seek(max(0, self._output.tell() - 4096))
        lines = [line.strip() for line in self._output.read().decode(errors="replace").splitlines()]
        return next((line[:SHOWN] for line in reversed(lines) if line), "")


def find_program(given: str) -> Path:
    """The program that a user means, in full: Unity's builds end otherwise on each system.

    Raises:
        UsageError: There is none, or it cannot be run.
    """
    path = Path(os.path.abspath(os.path.expanduser(given)))
    if sys.platform == "darwin" and (inside := _inside_app(path)):
        return inside
    for ending in ENDINGS.get(sys.platform, ("",)):
        found = path.with_name(path.name + ending)
        if found.is_file():
            if not os.access(found, os.X_OK):
                raise UsageError(f"file={given}: {found} may not be run. What to do: chmod +x {found}")
            return found
    raise UsageError(f"file={given}: there is no such program. Give the path of the player that Unity built")


def _inside_app(path: Path) -> Path | None:
    """The program in a folder that macOS shows as one file."""
    folder = path if path.suffix == ".app" else path.with_name(f"{path.name}.app")
    return next(iter(sorted((folder / "Contents" / "MacOS").glob("*"))), None)


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
