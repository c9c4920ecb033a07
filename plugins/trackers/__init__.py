"""Built-in trackers."""

from ..announced import register_trackers as register_trackers
