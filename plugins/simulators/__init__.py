"""Built-in simulators."""

from ..announced import register_simulators as register_simulators
