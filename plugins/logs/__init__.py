"""Built-in formats of logs."""

from ..announced import register_logs as register_logs
