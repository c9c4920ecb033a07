"""The package as it is imported: what is public, and what importing it costs."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import harness

HEAVY = ("torch", "mujoco", "stable_baselines3", "gymnasium", "pybullet", "dm_control")
ROOT = Path(harness.__file__).parent
MODULES = sorted(
    ".".join(["harness", *path.relative_to(ROOT).with_suffix("").parts]).removesuffix(".__init__")
    for path in ROOT.rglob("*.py")
    if "unity_player/__main__" not in path.as_posix()  # a program alone, which needs the extra unity
)
PUBLIC = [module for module in MODULES if module.count(".") <= 1]
"""The flat modules and the rooms."""

# Each module in a fork of its own, out of a process that has the libraries and none of ours: alone, and quick.
IMPORT_EACH_ALONE = """
import importlib, json, os, sys, traceback
os.environ["OPENBLAS_NUM_THREADS"] = "1"  # newer Pythons warn of forks beside threads
import gymnasium, numpy, pluggy, pyarrow.parquet, pydantic.dataclasses, rich, safetensors.numpy, tomli_w, typer, wrapt
import csv, importlib.metadata, statistics, tomllib, unicodedata, xml.etree.ElementTree, zipfile
pydantic.dataclasses.dataclass(type("First", (), {"__annotations__": {"number": int}}))  # imports the rest of pydantic
assert not [name for name in sys.modules if name == "harness" or name.startswith("harness.")]
errors = {}
for module in json.load(sys.stdin):
    reading, writing = os.pipe()
    if os.fork() == 0:
        os.close(reading)
        status = 0
        try:
            importlib.import_module(module)
        except BaseException:
            os.write(writing, traceback.format_exc()[-4000:].encode())
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as pipe:
        errors[module] = pipe.read()
    os.wait()
json.dump(errors, sys.stdout)
"""


def _python(script, *options, given=""):
    command = [sys.executable, *options, "-c", script]
    return subprocess.run(command, input=given, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("modules", [PUBLIC, pytest.param(MODULES, marks=pytest.mark.slow)], ids=["public", "all"])
def test_modules_can_be_imported_alone(modules):
    """Whichever is the first, without a circle, without a warning."""
    ended = _python(IMPORT_EACH_ALONE, "-W", "error", given=json.dumps(modules))
    assert ended.returncode == 0, ended.stderr
    assert json.loads(ended.stdout) == dict.fromkeys(modules, "")


def test_every_module_can_be_imported_in_reverse_order():
    """Where one needs another it imports that one; `test_layers` looks for circles in all of them."""
    ended = _python(f"import importlib\nfor name in {MODULES[::-1]}:\n    importlib.import_module(name)", "-W", "error")
    assert (ended.returncode, ended.stderr) == (0, "")


def test_all_is_what_is_exported():
    """Every public name of `__all__` exists, and `import *` brings these and no other."""
    brought = {}
    exec("from harness import *", brought)
    del brought["__builtins__"]
    assert sorted(brought) == harness.__all__ == sorted(harness.__all__)


def test_public_names_are_documented():
    """Each of them says what it is."""
    for name in harness.__all__:
        if name != "__version__":
            assert getattr(harness, name).__doc__, name


def test_unknown_name_is_no_attribute():
    """A slip of the finger is an AttributeError that names module and attribute."""
    with pytest.raises(AttributeError, match="module 'harness' has no attribute 'make_evn'"):
        _ = harness.make_evn


def test_version_is_the_distribution_s():
    """`harness.__version__` and the installed metadata agree."""
    from importlib.metadata import version

    assert harness.__version__ == version("fd100-harness")


@pytest.mark.parametrize("module", ["harness", "harness.cli", "harness.registry.registry", "harness.eta.index"])
def test_import_is_light(module):
    """Neither an engine nor a learning library nor Gymnasium comes with it."""
    script = f"import sys, {module}; print(*(set({HEAVY}) & set(sys.modules)))"
    ended = _python(script)
    assert (ended.stdout, ended.stderr) == ("\n", "")


def test_loading_the_registry_is_light():
    """Every plugin says what it has, and no engine is imported for it."""
    script = (
        "import sys; from harness.registry.registry import load_registry\n"
        "names = load_registry().names('simulators')\n"
        f"print('mujoco' in names, *(set({HEAVY}) & set(sys.modules)))"
    )
    assert _python(script).stdout == "True\n"


@pytest.mark.parametrize("order", ["import gymnasium, harness", "import harness, gymnasium"])
def test_environment_is_registered_in_both_import_orders(toys, order):
    """`gymnasium.make` and `gymnasium.make_vec` find the environment, whichever of the two is imported first."""
    script = (
        f"{order}\n"
        "env = gymnasium.make('harness/Reach-v0', simulator='ideal', disable_env_checker=True)\n"
        "print(env.reset(seed=0)[0].shape)\n"
        "envs = gymnasium.make_vec('harness/Reach-v0', num_envs=2, simulator='ideal')\n"
        "print(envs.reset(seed=0)[0].shape)\n"
        "env.close(); envs.close()\n"
    )
    ended = _python(script, "-W", "error")
    assert (ended.stdout, ended.stderr) == ("(28,)\n(2, 28)\n", "")


def test_importing_harness_leaves_gymnasium_alone():
    """Both environments are registered when Gymnasium is imported, and Gymnasium is not imported for it."""
    count = "import gymnasium; print(len(gymnasium.registry))"
    both = _python(f"import sys, harness; assert 'gymnasium' not in sys.modules; {count}")
    assert int(both.stdout) == int(_python(count).stdout) + 2


def test_typed():
    """Type checkers are told that the packages carry types."""
    import harness_plugins
    import harness_robots

    for package in (harness, harness_plugins, harness_robots):
        assert os.path.exists(os.path.join(os.path.dirname(package.__file__), "py.typed"))
