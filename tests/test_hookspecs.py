"""The hooks as they are declared."""

import inspect

from harness import Register
from harness.hookspecs import KINDS, Hooks


def test_kinds_are_the_hooks():
    """There is one hook per kind of thing that varies."""
    assert [f"register_{kind}" for kind in KINDS] == [name for name in vars(Hooks) if name.startswith("register_")]


def test_hooks_read_alike(subtests):
    """Every hook takes `register` alone, and its docstring says what a target has to be."""
    for kind in KINDS:
        with subtests.test(kind=kind):
            hook = getattr(Hooks, f"register_{kind}")
            assert list(inspect.signature(hook).parameters) == ["self", "register"]
            assert hook.__doc__.startswith("Targets: ")


def test_register_has_one_signature():
    """What a plugin says of a name: target and summary always, what it requires and the extra at will.

    A command may name its heading in the help.
    """
    parameters = inspect.signature(Register.__call__).parameters
    assert [name for name, item in parameters.items() if item.default is item.empty] == [
        "self",
        "name",
        "target",
        "summary",
    ]
    assert [name for name, item in parameters.items() if item.default is not item.empty] == [
        "requires",
        "extra",
        "heading",
        "short",
    ]
