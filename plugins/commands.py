"""Built-in commands that the core does without."""

from .announced import register_commands, register_screens, register_sections

__all__ = ["register_commands", "register_screens", "register_sections"]
