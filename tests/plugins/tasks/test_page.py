"""docs/tasks.md."""

import re
from pathlib import Path
from typing import Any

import pytest

from harness.registry.registry import load_registry

REGISTRY = load_registry()
PAGE = (Path(__file__).parents[3] / "docs" / "tasks.md").read_text(encoding="utf-8")
BUILT_IN = [name for name in REGISTRY.names("tasks") if REGISTRY.get("tasks", name).plugin == "tasks"]


@pytest.mark.parametrize("name", BUILT_IN)
def test_page_has_a_row(name: str):
    """Every built-in task is on the page, with its robot and its action."""
    task: Any = REGISTRY.get("tasks", name).load()()
    (row,) = [line for line in PAGE.splitlines() if line.startswith(f"| `{name}` |")]
    assert f"| {task.robot} |" in row
    assert f"| `{task.action}` |" in row


def test_examples_run():
    """A task that is written as the page says keeps the contract."""
    names: dict[str, Any] = {}
    examples = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert len(examples) == 2
    for example in examples:
        exec(example, names)
    assert "Shelf" in names
