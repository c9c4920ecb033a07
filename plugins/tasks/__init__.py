"""Built-in tasks."""

from ..announced import register_tasks as register_tasks
