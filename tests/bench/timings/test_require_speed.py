"""A bound that is missed, in a pytest of its own."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

MISSED = """
import pytest

@pytest.mark.bench
def test_candidate_is_slow(require_speed):
    require_speed(lambda: sum(range(300_000)), lambda: sum(range(3_000_000)), at_least=0.5, rounds=3)
"""


@pytest.mark.parametrize(("selected", "status"), [("bench", 1), ("not slow", 0)])
def test_missed_bound_fails_under_its_mark_alone(tmp_path, selected, status):
    """With ``-m bench`` the ratio is printed and the test fails; elsewhere it passes."""
    shutil.copy(Path(__file__).with_name("conftest.py"), tmp_path)
    (tmp_path / "test_missed.py").write_text(MISSED)
    (tmp_path / "pytest.ini").write_text("[pytest]\nmarkers = bench\n")
    command = [sys.executable, "-m", "pytest", "-s", "-m", selected, str(tmp_path)]
    # Told that several tests run at once, pytest-benchmark would measure nothing.
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_XDIST")}
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path, env=environment)
    assert done.returncode == status, done.stdout
    assert ("at least 0.500" in done.stdout) == bool(status)
