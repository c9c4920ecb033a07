"""Built-in executors."""

from ..announced import register_executors as register_executors
