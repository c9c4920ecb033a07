"""How long a user waits for a command that computes nothing."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.bench


@pytest.mark.parametrize(("argument", "times"), [("--help", 4), ("describe", 5)])
def test_light_commands_beside_their_library(require_speed, argument, times):
    """They take a few times as long as `python -c "import typer"`.

    2.6 and 3.6 was measured: 0.2 s where that takes 0.07. With numpy a help took 6.
    """
    command = shutil.which("harness", path=str(Path(sys.executable).parent))
    assert command is not None

    def call(*arguments):
        subprocess.run(arguments, check=True, capture_output=True)

    require_speed(
        lambda: call(sys.executable, "-c", "import typer"), lambda: call(command, argument), 1 / times, rounds=15
    )


PLUGIN = """
import harness

@harness.hookimpl
def register_rewards(register):
    register(__name__, f"{__name__}_code:Mine", summary="pays")

@harness.hookimpl
def register_commands(register):
    register(__name__, f"{__name__}_code:wave", summary="waves")
"""


def test_help_with_fifty_plugins_beside_bare_starts(require_speed, tmp_path):
    """One of them is broken. 16 bare starts are 0.3 s where Python starts in 18 ms."""
    for number in range(50):
        name = f"plugin_{number}"
        (tmp_path / f"{name}.py").write_text(PLUGIN if number else "raise OSError")
        metadata = tmp_path / f"{name}-1.0.dist-info"
        metadata.mkdir()
        (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
        (metadata / "entry_points.txt").write_text(f"[harness]\n{name} = {name}\n")
    path = os.pathsep.join(filter(None, [str(tmp_path), os.environ.get("PYTHONPATH")]))

    def call(*arguments):
        done = subprocess.run(
            arguments, check=True, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": path}
        )
        return done.stdout

    helped = (sys.executable, "-m", "harness", "--help", "--all")
    assert call(*helped).count("waves") == 49
    require_speed(lambda: call(sys.executable, "-c", "pass"), lambda: call(*helped), 1 / 16, rounds=15)
