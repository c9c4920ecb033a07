"""A plugin's name, and the names that follow from it."""

import builtins
import importlib.util
import keyword
import re
import sys
from dataclasses import dataclass

from harness.errors import UsageError

_NAME = re.compile(r"[a-z][a-z0-9]*(-[a-z0-9]+)*")
LONGEST = 60


@dataclass(frozen=True)
class PluginName:
    """What users type, as ``my-reward``: words of lower-case letters and digits, joined by single hyphens.

    Such a name is its own normal form on a package index (PEP 503), and identifiers follow from it.

    Raises:
        UsageError: It is none, or the identifiers are taken.
    """

    text: str

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.text) or len(self.text) > LONGEST:
            raise UsageError(
                f"The name '{self.text}' must be words of lower-case letters and digits joined by '-', begin with a "
                f"letter and have at most {LONGEST} characters.{_suggestion(self.text)}"
            )
        owner = self._owner()
        if owner:
            raise UsageError(
                f"The name '{self.text}' becomes the module '{self.module}', which is {owner}: choose another name"
            )

    @property
    def module(self) -> str:
        """Import name of the package, ``my_reward``."""
        return self.text.replace("-", "_")

    @property
    def class_name(self) -> str:
        """The name of the class, ``MyReward``."""
        return "".join(word.capitalize() for word in self.text.split("-"))

    def _owner(self) -> str:
        """Who has the module's or the class's name already; empty if nobody."""
        if keyword.iskeyword(self.module) or hasattr(builtins, self.class_name):
            return "a word of Python"
        if self.module in sys.stdlib_module_names:
            return "a module of Python"
        if self.module == "tests":  # stands beside it
            return "the folder of its tests"
        return "a module that is installed" if importlib.util.find_spec(self.module) else ""


def _suggestion(text: str) -> str:
    near = re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")
    return f" Did you mean '{near}'?" if _NAME.fullmatch(near) and len(near) <= LONGEST else ""
