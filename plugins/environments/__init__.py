"""Built-in environments."""

from ..announced import register_environments as register_environments
