"""How the process of a check came to its end, in plain words."""

import re
import signal
import sysconfig
from pathlib import Path

import harness

SIGNALS = {
    "SIGSEGV": "a segmentation fault (SIGSEGV) ended the process",
    "SIGBUS": "a bus error (SIGBUS) ended the process",
    "SIGFPE": "an arithmetic fault (SIGFPE) ended the process",
    "SIGILL": "an illegal instruction (SIGILL) ended the process",
    "SIGABRT": "the process was aborted (SIGABRT)",
    "SIGKILL": "the process was killed (SIGKILL): by the plugin, or by the system if memory was short",
}
"""By the name of the signal that ended a process."""
DUMP = "Fatal Python error: "
"""Begins what `faulthandler` writes of a process that crashes or is aborted."""
OURS = (Path(harness.__file__).parent, Path(__file__).parents[1])
"""The folders of the harness, and of this kit."""
_FRAME = re.compile(r'^  File "(?P<file>[^"]+)", line (?P<line>\d+) in ', re.MULTILINE)


def ending_in_words(status: int) -> str:
    """What an exit status says, which a process had before its work was done; negative: the number of a signal."""
    if status >= 0:
        return f"the plugin ended the process: exit status {status}"
    try:
        name = signal.Signals(-status).name
    except ValueError:
        return f"signal {-status} ended the process"
    return SIGNALS.get(name, f"the signal {name} ended the process")


def split_output(text: str) -> tuple[str, str]:
    """What a plugin printed, and what Python wrote when its process crashed, which is empty if it did not."""
    printed, begin, dump = text.rpartition(DUMP)
    return (printed, begin + dump) if begin else (text, "")


def is_plugins_own(file: str) -> bool:
    """Whether a file of a stack is of the plugin, or of a library that it uses: not Python's, and not the harness's."""
    path, python = Path(file), Path(sysconfig.get_path("stdlib"))
    is_pythons = python in path.parents and "site-packages" not in path.parts
    return path.is_absolute() and not is_pythons and not {*OURS} & {*path.parents}


def place_in(dump: str) -> str:
    """File and line of the plugin in what Python wrote: of its last call. Empty if the plugin is not in it."""
    current = dump.partition("Current thread")[2].partition("\n\n")[0]
    own = (match for match in _FRAME.finditer(current) if is_plugins_own(match["file"]))
    return next((f"{Path(match['file']).name}, line {match['line']}" for match in own), "")
