"""Python imports this before anything else where its folder is on PYTHONPATH: which of our files a process enters.

It writes a JSON file into the folder $ENTERED_INTO when the process ends: `files`, `hops`, `back` and `loaded`, as
`tests.architecture.entered` says. TOPS are the folders whose files are ours.
"""

import atexit
import json
import os
import sys
import threading
from pathlib import Path

TOPS = tuple(os.environ["ENTERED_TOPS"].split(os.pathsep))
OPTIMIZED = 1
"""Set in the code of a function, not in that of a module or a class, which runs when it is imported."""
files = {}
hops = set()
back = set()


def _is_ours(frame):
    return frame.f_code.co_filename.startswith(TOPS)


def _at_import(frame):
    """Whether a module is being imported, with what it calls."""
    while frame is not None:
        if _is_ours(frame) and frame.f_code.co_name == "<module>" and frame.f_globals["__name__"] != "__main__":
            return True
        frame = frame.f_back
    return False


def _enter(frame, event, argument):
    """See each call, and no line of it."""
    if not _is_ours(frame) or not frame.f_code.co_flags & OPTIMIZED:
        return
    file, caller = frame.f_code.co_filename, frame.f_back
    while caller is not None and not _is_ours(caller):
        caller = caller.f_back
    hop = (caller.f_code.co_filename, file) if caller is not None and caller.f_code.co_flags & OPTIMIZED else None
    if (file in files and (hop is None or hop[0] == file or hop in hops)) or _at_import(frame):
        return
    if hop is not None and hop[0] != file:
        hops.add(hop)
        if file in files:
            back.add(hop)
    files.setdefault(file)


def _write():
    sys.settrace(None)
    if files:
        own = (getattr(module, "__file__", None) or "" for module in list(sys.modules.values()))
        loaded = [file for file in own if file.startswith(TOPS)]
        told = {"files": list(files), "hops": sorted(hops), "back": sorted(back), "loaded": loaded}
        Path(os.environ["ENTERED_INTO"], f"{os.getpid()}.json").write_text(json.dumps(told))


atexit.register(_write)
threading.settrace(_enter)
sys.settrace(_enter)
