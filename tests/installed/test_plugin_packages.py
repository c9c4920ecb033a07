"""Packages of plugins as their authors install and test them: new ones of every kind, and those in `examples/`."""

import ast
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from pathlib import Path

import pytest

from harness_plugins.kit.new_plugin import kinds
from tests.installed.conftest import make_environment
from tests.project import ROOT

EXAMPLES = {path.parent.name: path.parent for path in sorted(ROOT.glob("examples/*/pyproject.toml"))}
EARLIER = zipfile.ZipFile(Path(__file__).parents[1] / "compatibility" / "packages_0_3.zip")
"""What `harness new-plugin` of 0.3.0 wrote of every kind, and the packages of its examples."""
NO_TESTS = 5
"""Exit status of pytest where all tests are skipped before they are collected."""


def run(*command, cwd):
    """A command in a folder, and what it printed."""
    return subprocess.run([str(part) for part in command], cwd=cwd, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def python(tmp_path_factory):
    """Python of a new environment, which sees the libraries of this one: what is installed there stays there."""
    folder = tmp_path_factory.mktemp("fresh")
    made = run(sys.executable, "-m", "venv", "--without-pip", folder, cwd=folder)
    assert made.returncode == 0, made.stderr
    own, here = (Path(sysconfig.get_path("purelib", vars=base)) for base in ({"base": str(folder)}, {}))
    (own / "this.pth").write_text(f"import site; site.addsitedir({str(here)!r})\n")
    return Path(sysconfig.get_path("scripts", vars={"base": str(folder)})) / Path(sys.executable).name


def install(python, folder, *options, cwd):
    """As `pip install -e`, from nowhere but here."""
    offline = ("--no-index", "--no-build-isolation", "--disable-pip-version-check", "--quiet", *options)
    done = run(sys.executable, "-m", "pip", "--python", python, "install", *offline, "-e", folder, cwd=cwd)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("kind", kinds())
def test_new_plugin_passes_its_tests(python, tmp_path, kind):
    """From an empty folder by three commands, as they are typed."""
    name = f"zz-{kind}"
    made = run(python, "-m", "harness", "new-plugin", kind, name, cwd=tmp_path)
    assert made.returncode == 0, made.stderr
    install(python, f"{name}[test]", cwd=tmp_path)
    tested = run(python, "-m", "pytest", "-p", "no:cacheprovider", name, cwd=tmp_path)
    assert tested.returncode == 0, tested.stdout
    assert " passed" in tested.stdout
    shown = run(python, "-m", "harness", "doctor", cwd=tmp_path).stdout
    assert f"  {name} 0.1.0: {name} (" in shown


@pytest.mark.slow
def test_workflow_of_a_new_plugin_needs_no_index_for_the_harness(core, wheel, tmp_path):
    """Its lines, typed in an empty environment; `wheels` holds what README says to put there."""
    assert core.harness("new-plugin", "reward", "zz-kept", cwd=tmp_path).status == 0
    package = tmp_path / "zz-kept"
    (package / "wheels").mkdir()
    shutil.copy(wheel, package / "wheels")
    workflow = (package / ".github/workflows/test.yml").read_text()
    first, *others = [shlex.split(line)[1:] for line in re.findall(r"- run: (.*)", workflow)]
    env = make_environment(tmp_path / "env")
    env.install(*first[first.index("install") + 1 :], cwd=package)
    for command in others:
        status, out, err = env.run(*command, cwd=package)
        assert status == 0, out + err
        assert " passed" in out


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_example_passes_its_tests(python, tmp_path, name):
    """Those whose library is installed; the others say what to install."""
    install(python, EXAMPLES[name], "--no-deps", cwd=tmp_path)
    tested = run(python, "-m", "pytest", "-p", "no:cacheprovider", "-rs", EXAMPLES[name], cwd=tmp_path)
    if tested.returncode == NO_TESTS and "is not installed: pip install" in tested.stdout:
        pytest.skip(next(line for line in tested.stdout.splitlines() if "is not installed" in line))
    assert tested.returncode == 0, tested.stdout


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted({path.partition("/")[0] for path in EARLIER.namelist()}))
def test_earlier_package_passes_its_tests(python, tmp_path, name):
    """As its author wrote it for 0.3."""
    EARLIER.extractall(tmp_path, [path for path in EARLIER.namelist() if path.startswith(f"{name}/")])
    install(python, tmp_path / name, "--no-deps", cwd=tmp_path)
    tested = run(python, "-m", "pytest", "-p", "no:cacheprovider", "-rs", name, cwd=tmp_path)
    skipped = tested.returncode == NO_TESTS and "is not installed: pip install" in tested.stdout
    assert tested.returncode == 0 or skipped, tested.stdout


@pytest.mark.parametrize("name", EXAMPLES)
def test_example_is_complete(name):
    """It has a README, tests, an entry point, and the class or folder that its hook announces."""
    folder = EXAMPLES[name]
    project = tomllib.loads((folder / "pyproject.toml").read_text())["project"]
    assert project["name"] in {name, "cautious-reward"}
    assert f'pip install -e "examples/{name}[test]"' in (folder / "README.md").read_text()
    assert list((folder / "tests").glob("test_*.py"))
    (module,) = project["entry-points"]["harness"].values()
    plugin = ast.parse((folder / f"{module.replace('.', '/')}.py").read_text())
    texts = [node.value for node in ast.walk(plugin) if isinstance(node, ast.Constant) and isinstance(node.value, str)]
    (target,) = [text for text in texts if text.count(":") == 1 and " " not in text]
    home, attribute = target.split(":")
    code = (folder / f"{home.replace('.', '/')}.py").read_text()
    assert f"class {attribute}:" in code or f"\n{attribute} = " in code


def test_example_reward_keeps_its_contract(monkeypatch):
    """The one that remembers, without being installed."""
    monkeypatch.syspath_prepend(EXAMPLES["memory-reward"])
    from memory_reward.reward import Steady

    from harness_plugins.kit import check_contract

    check_contract("reward", Steady())


def test_example_robot_is_read():
    """Its URDF, its settings and its meshes."""
    from harness import load_robot

    assert load_robot(EXAMPLES["mesh-arm"] / "mesh_arm" / "arm").dof == 5
