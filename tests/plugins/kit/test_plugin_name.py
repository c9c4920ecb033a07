"""Names of new plugins."""

import pytest
from hypothesis import given, settings, strategies as st

from harness.errors import UsageError
from harness_plugins.kit.new_plugin import PluginName


def test_identifiers_follow_from_the_name():
    """The package's import name, and its class."""
    name = PluginName("my-2nd-reward")
    assert (name.module, name.class_name) == ("my_2nd_reward", "My2ndReward")


@settings(max_examples=20)
@given(st.from_regex(r"zz[a-z0-9]{0,5}(-[a-z0-9]{1,5}){0,3}", fullmatch=True))
def test_identifiers_are_identifiers(text):
    """Of any name that is allowed."""
    name = PluginName(text)
    assert name.module.isidentifier()
    assert name.class_name.isidentifier()


@pytest.mark.parametrize(
    "text", ["", "My-Reward", "my_reward", "-mine", "mine-", "my--reward", "2nd", "a b", "../up", "é", "a\n", "a" * 61]
)
def test_other_texts_are_refused(text):
    """With what is allowed."""
    with pytest.raises(UsageError, match=r"words of lower-case letters and digits.*at most 60 characters"):
        PluginName(text)


@pytest.mark.parametrize(("text", "near"), [("My_Reward", "my-reward"), ("a b", "a-b"), ("mine-", "mine")])
def test_nearest_name_is_offered(text, near):
    """Where capitals, underscores or blanks were all that is wrong."""
    with pytest.raises(UsageError, match=f"Did you mean '{near}'"):
        PluginName(text)


@pytest.mark.parametrize(
    ("text", "owner"),
    [
        ("class", "a word of Python"),
        ("none", "a word of Python"),
        ("json", "a module of Python"),
        ("numpy", "a module that is installed"),
        ("harness", "a module that is installed"),
        ("tests", "the folder of its tests"),
    ],
)
def test_name_of_another_module_is_refused(text, owner):
    """Its package could not be imported, or would hide another."""
    with pytest.raises(UsageError, match=owner):
        PluginName(text)
