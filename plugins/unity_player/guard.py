"""Starts a player and ends it when whoever asked for it is gone. It runs as a script and imports nothing of ours.

Unity's players go on when the program that talks to them is killed. This script stands between the two: its standard
input ends with that program, however that ends.
"""

import os
import signal
import subprocess
import sys
import threading

POSIX = os.name == "posix"


def main(command: list[str]) -> int:
    """Run the player; the exit status is that of the player, 128 and more where a signal ended it."""
    if POSIX:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # whoever asked for the player decides
    player = subprocess.Popen(command, stdin=subprocess.DEVNULL, start_new_session=POSIX)

    def end_with_asker() -> None:
        while os.read(0, 1):  # a thread in Python's own reader would abort this process when it ends
            pass
        kill(player)

    threading.Thread(target=end_with_asker, daemon=True).start()
    code = player.wait()
    kill(player)  # what it started and left
    return code if code >= 0 else 128 - code


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
