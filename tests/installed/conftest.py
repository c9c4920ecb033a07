"""The project as people install it: from a wheel, in new environments outside the checkout."""

import os
import subprocess
import sys
import sysconfig
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.project import ROOT

WHEEL = "HARNESS_WHEEL"
"""The environment variable that names a wheel that is built; without it the tests build one."""
PIP = ("--disable-pip-version-check", "--quiet", "--no-input")
MINUTES = 10
"""What any command here may take; some install libraries."""


class Answer(NamedTuple):
    """What a command left."""

    status: int
    out: str
    err: str


class Environment(NamedTuple):
    """A Python environment outside the checkout."""

    python: Path

    def run(self, *command, cwd, **variables):
        """A command of this environment's Python, in a folder; what the checkout has is out of its sight."""
        surroundings = {
            name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "HARNESS_"))
        }
        done = subprocess.run(
            [self.python, *map(str, command)],
            cwd=cwd,
            env={**surroundings, "COLUMNS": "200", "OMP_NUM_THREADS": "1", **variables},
            capture_output=True,
            text=True,
            check=False,
            timeout=60 * MINUTES,
        )
        return Answer(done.returncode, done.stdout, done.stderr)

    def harness(self, *arguments, cwd, **variables):
        """A command of the harness."""
        return self.run("-P", "-m", "harness", *arguments, cwd=cwd, **variables)

    def install(self, *arguments, cwd):
        """As `pip install` in this environment."""
        command = [sys.executable, "-m", "pip", "--python", self.python, "install", *PIP, *arguments]
        done = subprocess.run([*map(str, command)], cwd=cwd, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="session")
def wheel(tmp_path_factory):
    """The wheel, built from the source archive, as users get it."""
    if os.environ.get(WHEEL):
        return (ROOT / os.environ[WHEEL]).resolve()
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "build", "--no-isolation", "--quiet", "--outdir", str(folder), str(ROOT)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (built,) = folder.glob("*.whl")
    return built


def make_environment(folder, behind=None):
    """A new environment.

    Args:
        folder: Where.
        behind: Another one, whose packages it sees behind its own.
    """
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder)], check=True)
    paths = sysconfig.get_paths(vars={"base": str(folder), "platbase": str(folder)})
    if behind is not None:
        above = sysconfig.get_path("purelib", vars={"base": str(behind.python.parents[1])})
        (Path(paths["purelib"]) / "above.pth").write_text(f"import site; site.addsitedir({above!r})\n")
    return Environment(Path(paths["scripts"]) / Path(sys.executable).name)


@pytest.fixture(scope="session")
def core(wheel, tmp_path_factory):
    """The wheel without any extra."""
    folder = tmp_path_factory.mktemp("core")
    made = make_environment(folder / "env")
    made.install(wheel, cwd=folder)
    return made


@pytest.fixture(scope="session")
def with_extras(core, tmp_path_factory):
    """Environments with extras: what an installed harness says to type, `pip install 'fd100-harness[sb3]'`."""
    made = {}

    def make(extras):
        if not extras:
            return core
        if extras not in made:
            folder = tmp_path_factory.mktemp("-".join(extras)[:40])
            made[extras] = make_environment(folder / "env", core)
            made[extras].install(f"fd100-harness[{','.join(extras)}]", cwd=folder)
        return made[extras]

    return make
