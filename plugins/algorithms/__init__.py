"""Built-in algorithms."""

from ..announced import register_algorithms as register_algorithms
