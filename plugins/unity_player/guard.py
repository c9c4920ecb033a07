"""Starts a player and ends it when whoever asked for it is gone. It runs as a script and imports nothing of ours.

Unity's players go on when the program that talks to them is killed. This script stands between the two: its standard
input ends with that program, however that ends. If this script is killed itself, Linux ends the player.

What the player prints goes to this script's output, a file, of which no more than `MOST` bytes are kept: the newest.
"""

import ctypes
import os
import signal
import subprocess
import sys
import threading
from contextlib import suppress
from functools import partial

POSIX = os.name == "posix"
MOST, KEPT, PIECE = 2**20, 2**16, 2**16
"""Bytes of the output: so many at most, so many that are left when there are more, and so many at once."""
END_WITH_PARENT = 1
"""PR_SET_PDEATHSIG of Linux: the signal that a process gets when the one that started it ends."""
PATIENCE = 1.0
"""Seconds to wait for output that something still holds open which the player started."""


def main(command: list[str]) -> int:
    """Run the player; the exit status is that of the player, 128 and more where a signal ended it."""
    if POSIX:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # whoever asked for the player decides
    player = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        start_new_session=POSIX,
        preexec_fn=partial(end_with, os.getpid()) if sys.platform == "linux" else None,  # noqa: PLW1509 # no thread runs yet
    )
    assert player.stdout is not None
    output = threading.Thread(target=keep_newest, args=(player.stdout.fileno(), 1), daemon=True)
    output.start()

    def end_with_asker() -> None:
        while os.read(0, 1):  # a thread in Python's own reader would abort this process when it ends
            pass
        kill(player)

    threading.Thread(target=end_with_asker, daemon=True).start()
    code = player.wait()
    kill(player)  # what it started and left
    output.join(PATIENCE)
    return code if code >= 0 else 128 - code


def end_with(parent: int) -> None:
    """Have Linux kill this process when its parent ends, however that ends."""
    ctypes.CDLL(None).prctl(END_WITH_PARENT, int(signal.SIGKILL))
    if os.getppid() != parent:  # it ended meanwhile
        os._exit(1)


def keep_newest(source: int, target: int) -> None:
    """Copy what comes from `source` to the file `target`, until it ends; the file never has more than `MOST` bytes."""
    newest, length = b"", 0
    while piece := os.read(source, PIECE):
        newest = (newest + piece)[-KEPT:]
        with suppress(OSError):  # a full disk: what does not fit is lost, and the player goes on
            if length + len(piece) > MOST:
                os.lseek(target, 0, os.SEEK_SET)
                os.ftruncate(target, 0)
                piece, length = newest, 0
            length += os.write(target, piece)


def kill(player: "subprocess.Popen[bytes]") -> None:
    """End the player and all that it started."""
    try:
        if POSIX:
            os.killpg(player.pid, signal.SIGKILL)
        else:
            player.kill()
    except ProcessLookupError:
        return


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
