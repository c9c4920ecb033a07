"""The server that Unity connects to, as two queues: what Unity says, and what it is answered."""

import queue
import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import Any

import grpc

from harness.errors import UsageError

from .protocol import UnityToExternalProtoServicer, add_UnityToExternalProtoServicer_to_server

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
