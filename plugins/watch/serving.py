"""Pages for the browsers of this machine. What they ask for is made once for all; who is slow holds no thread."""

import asyncio
import os
import socket
from asyncio import IncompleteReadError, LimitOverrunError, StreamReader, StreamWriter
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import contextmanager
from functools import partial
from math import inf
from threading import Lock, Thread
from time import monotonic
from typing import Generic, TypeVar

from harness.cli.output import complain
from harness.cli.unexpected import describe_unexpected
from harness.errors import HarnessError, UsageError, one_line

T = TypeVar("T")
HOST = "127.0.0.1"
"""Nobody else on the network sees the pages."""
EVERY = 1.0
"""Seconds for which what was made is given to whoever asks."""
PATIENCE = 60.0
"""Seconds to wait for a client that asks nothing, or does not read."""
PIECE = 2**16
"""Bytes that are sent at a time, and that a client may ask with."""


class Kept(Generic[T]):
    """What is made when somebody asks, in a thread of its own; all who ask meanwhile and soon afterwards share it."""

    def __init__(self, make: Callable[[], T], rest: float = 0.0) -> None:
        """Make nothing yet.

        Args:
            make: Makes it.
            rest: It is kept for `EVERY` seconds and for so many times as long as making it took.
        """
        self._make, self._rest, self._lock = make, rest, Lock()
        self._made, self._until = Future[T](), 0.0

    def __call__(self) -> Future[T]:
        """What there is, or will be."""
        with self._lock:
            if monotonic() >= self._until:
                self._made, self._until = Future(), inf
                self._made.set_running_or_notify_cancel()  # a client that leaves cancels it for nobody
                Thread(target=self._work, args=(self._made,), daemon=True).start()
            return self._made

    def _work(self, made: "Future[T]") -> None:
        begun = monotonic()
        try:
            made.set_result(self._make())
        except Exception as error:
            made.set_exception(error)
        self._until = monotonic() + EVERY + self._rest * (monotonic() - begun)


@contextmanager
def serving(pages: Mapping[str, Callable[[], str]], port: int) -> Iterator[str]:
    """Serve pages on this machine alone, in a thread of its own; gives the address.

    Args:
        pages: What makes each, by its path: that of ``/`` is HTML, others are JSON.
        port: 0: any that is free.

    Raises:
        UsageError: The port is taken.
    """
    try:
        door = socket.create_server((HOST, port))
    except OSError as error:
        told = os.strerror(error.errno or 0)
        raise UsageError(f"--port {port} cannot be had: {told}. Give another, or leave it out") from error
    routes = {f"GET {path}": Kept(make) for path, make in pages.items()}
    ended = Future[None]()

    async def serve() -> None:
        server = await asyncio.start_server(partial(_client, routes), sock=door, limit=PIECE)
        await asyncio.wrap_future(ended)
        server.close()

    thread = Thread(target=asyncio.run, args=(serve(),), daemon=True)
    thread.start()
    try:
        yield f"http://{HOST}:{door.getsockname()[1]}/"
    finally:
        ended.set_result(None)
        thread.join()


async def _client(routes: Mapping[str, Kept[str]], reader: StreamReader, writer: StreamWriter) -> None:
    """Answer one client, which may leave at any time."""
    try:
        async with asyncio.timeout(PATIENCE):
            head = await reader.readuntil(b"\r\n\r\n")
        answer = await _answer(routes, head.decode("latin-1"))
        writer.transport.set_write_buffer_limits(0)  # what is written next waits until the client has read
        for begin in range(0, len(answer), PIECE):
            writer.write(answer[begin : begin + PIECE])
            async with asyncio.timeout(PATIENCE):
                await writer.drain()
    except (ConnectionError, TimeoutError, IncompleteReadError, LimitOverrunError):
        pass  # as a browser does whenever a page is closed
    except Exception as error:
        complain(describe_unexpected(error))
    finally:
        writer.transport.abort()


async def _answer(routes: Mapping[str, Kept[str]], head: str) -> bytes:
    """The answer to a request, by its head."""
    request, *headers = head.split("\r\n")
    host = next((it[5:].strip() for it in headers if it.lower().startswith("host:")), "")
    asked = request.rpartition(" ")[0]
    if asked not in routes or host.rpartition(":")[0] not in {
        HOST,
        "localhost",
    }:  # no page of elsewhere asks by another name
        return _message("404 Not Found", "text/plain", "There is nothing here.")
    try:
        kind = "text/html" if asked == "GET /" else "application/json"
        return _message("200 OK", kind, await asyncio.wrap_future(routes[asked]()))
    except (HarnessError, OSError) as error:  # the folder may be gone by now
        return _message("500 Internal Server Error", "text/plain", one_line(error))


def _message(status: str, kind: str, text: str) -> bytes:
    body = text.encode(errors="backslashreplace")
    told = f"Content-Type: {kind}; charset=utf-8\r\nContent-Length: {len(body)}\r\nCache-Control: no-store"
    return f"HTTP/1.1 {status}\r\n{told}\r\nConnection: close\r\n\r\n".encode() + body
