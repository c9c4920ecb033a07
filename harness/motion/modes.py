"""The action modes by their names."""

from typing import Annotated, Any

from pydantic import Field
from pydantic.dataclasses import dataclass

from harness.errors import UsageError
from harness.motion.discrete import Discrete
from harness.motion.motion import Motion, MoveJAbsoluteMode, MoveJMode, SetJointsMode, Setting
from harness.motion.tip import MoveAMode, MoveLMode
from harness.registry.choice import parse
from harness.registry.members import build
from harness.registry.spec import did_you_mean


@dataclass(frozen=True)
class DiscreteMode:
    """One choice of many: stay, or one increment minus or plus of one joint (of one axis, for movel and movea)."""

    action: Annotated[str, Field(description="action mode whose increments are the choices")] = "movej"

    def motion(self, setting: Setting) -> Discrete:
        """The motion of one arm."""
        return Discrete(build_motion(self.action, setting, within="discrete"))


MODES: dict[str, Any] = {
    "movej": MoveJMode,
    "movej-absolute": MoveJAbsoluteMode,
    "movel": MoveLMode,
    "movea": MoveAMode,
    "set-joints": SetJointsMode,
    "discrete": DiscreteMode,
}
"""Frozen dataclasses whose fields are the mode's parameters, each with ``motion(setting) -> Motion``."""


def build_motion(text: str, setting: Setting, within: str = "") -> Motion:
    """The motion that `text` names, ``movej`` or ``movel:frame=tcs,tip_speed=0.3``.

    Args:
        text: A mode and its parameters.
        setting: Of the task.
        within: The mode whose parameter `text` is, if any; it does not nest.

    Raises:
        UsageError: Unknown mode or parameter, wrong type, out of range, or `within` again.
    """
    name, given = parse(text)
    if name == within:
        raise UsageError(f"Action mode '{within}' is given '{text}': it cannot stand inside itself")
    if name not in MODES:
        names = [mode for mode in MODES if mode != within]
        raise UsageError(f"No action mode '{name}'. There is: {', '.join(names)}.{did_you_mean(name, names)}")
    motion: Motion = build(MODES[name], _handed_inwards(given), f"action mode '{name}'").motion(setting)
    return motion


def _handed_inwards(given: dict[str, str]) -> dict[str, str]:
    """In ``discrete:action=movel:frame=tcs,parts=2`` what follows the inner mode's first parameter is its too."""
    if ":" not in given.get("action", ""):
        return given
    return {"action": ",".join([given["action"], *(f"{key}={text}" for key, text in given.items() if key != "action")])}
