"""Results are read without what made them."""

import subprocess
import sys

import pytest

MAKERS = {"harness.robot", "harness.policy", "harness.env", "harness.motion", "harness.experiment", "gymnasium"}
LOADED = "import sys, {module}; print(*(name for name, it in sys.modules.items() if getattr(it, '__file__', None)))"


def makers_loaded_by(module):
    """What an import loads of `MAKERS`, in a process of its own."""
    code = LOADED.format(module=module)
    loaded = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout.split()
    assert module in loaded
    return {maker for maker in MAKERS for name in loaded if name == maker or name.startswith(f"{maker}.")}


@pytest.mark.parametrize(
    "module",
    ["harness.results", "harness.report.page.html", "harness.report.page.eta", "harness.score.compare"],
)
def test_reading_loads_nothing_that_acts(module):
    """No robot, no policy, no environment, no motion, no experiment and no Gymnasium."""
    assert makers_loaded_by(module) == set()


def test_module_that_acts_is_noticed():
    """The check itself: an environment needs most of them."""
    assert {"harness.env", "harness.robot", "gymnasium"} <= makers_loaded_by("harness.env.vector_env")
