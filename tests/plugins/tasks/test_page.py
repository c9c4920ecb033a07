"""docs/tasks.md."""

from tests.project import page_of
from tests.registered import REGISTRY

PAGE = page_of("tasks")
BUILT_IN = [name for name in REGISTRY.names("tasks") if REGISTRY.get("tasks", name).plugin == "tasks"]


def test_page_has_a_row(subtests):
    """Every built-in task is on the page, with its robot and its action."""
    for name in BUILT_IN:
        with subtests.test(name=name):
            task = REGISTRY.get("tasks", name).load()()
            (row,) = [line for line in PAGE.splitlines() if line.startswith(f"| `{name}` |")]
            assert f"| {task.robot} |" in row
            assert f"| `{task.action}` |" in row
