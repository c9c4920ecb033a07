"""Built-in trackers."""

import harness


@harness.hookimpl
def register_trackers(register: harness.Register) -> None:
    """Announce the built-in trackers."""
    register(
        "tensorboard",
        "harness_plugins.trackers.tensorboard:TensorBoard",
        summary="event files for TensorBoard, in the experiment's folder",
        requires=("tensorboard",),
        extra="tensorboard",
    )
    register(
        "wandb",
        "harness_plugins.trackers.wandb:WandB",
        summary="Weights & Biases, online or offline",
        requires=("wandb",),
        extra="wandb",
    )
