"""The public face for whoever writes commands."""

import ast
from pathlib import Path

from harness.authoring import commands


def test_every_name_that_type_checkers_know_is_there():
    """Each of them once, and nothing else."""
    block = next(node for node in ast.parse(Path(commands.__file__).read_text()).body if isinstance(node, ast.If))
    names = [name.asname for line in block.body for name in line.names]
    assert sorted(names) == commands.__all__
    assert not [name for name in names if getattr(commands, name) is None]
