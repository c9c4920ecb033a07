"""The peak of this process's memory since the last call of `forget_peak`."""

import sys
from pathlib import Path

FORGET, STATUS = Path("/proc/self/clear_refs"), Path("/proc/self/status")
PEAK = "VmHWM:"


def forget_peak() -> None:
    """Forget the peak so far. Only Linux can do that; elsewhere the peak stays that of the whole process."""
    try:
        FORGET.write_text("5")
    except OSError:
        return  # no Linux, or one that allows it to nobody


def peak_memory() -> int:
    """The peak in bytes; 0 if the system does not tell it, as on Windows."""
    try:
        lines = STATUS.read_text().splitlines()
        return 1024 * int(next(line.split()[1] for line in lines if line.startswith(PEAK)))
    except (OSError, StopIteration):
        return _peak_of_process()


def _peak_of_process() -> int:
    if sys.platform == "win32":
        return 0
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak
