"""Built-in metrics. They say how well a robot behaves, no matter which reward paid it."""

from ..announced import register_metrics as register_metrics
