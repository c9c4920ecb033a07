"""How much of the harness an audit of a data set loads, counted in a fresh process."""

import os
import subprocess
import sys

from tests.record.dataset.written import episode, write_minari

MOST = 100
COUNT = """
import contextlib, io, sys
from harness.cli import main

def loaded(*arguments):
    with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):
        main([*arguments])
    return {name for name in sys.modules if name.startswith("harness") and hasattr(sys.modules[name], "__file__")}

print(*sorted(loaded("audit", sys.argv[1])))
"""


def test_an_audit_loads_few_files(tmp_path):
    """No more than `MOST`, with the command line and the registry; nothing that knows cells, recordings or arms."""
    folder = write_minari(tmp_path / "d", [episode(6, number, number % 2 == 1) for number in range(12)])
    run = [sys.executable, "-c", COUNT, f"minari:{folder}"]
    environment = {key: value for key, value in os.environ.items() if key != "HARNESS_PLUGINS"}
    told = subprocess.run(run, capture_output=True, text=True, check=True, env=environment).stdout.split()
    assert "harness_plugins.audit.dataset.audit_dataset" in told
    assert len(told) <= MOST
    assert not [name for name in told if name.startswith(("harness.results", "harness.recorder", "harness.score"))]
