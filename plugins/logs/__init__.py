"""Built-in formats of logs."""

import harness


@harness.hookimpl
def register_logs(register: harness.Register) -> None:
    """Announce the built-in formats."""
    register(
        "monitor",
        "harness_plugins.logs.monitor:Monitor",
        summary="stable-baselines3's Monitor and Gymnasium's old one: monitor.csv, a row is an episode",
    )
    register(
        "evaluations",
        "harness_plugins.logs.evaluations:Evaluations",
        summary="stable-baselines3's EvalCallback: evaluations.npz, a row is an episode of an evaluation",
    )
    register(
        "tensorboard",
        "harness_plugins.logs.tensorboard:TensorBoard",
        summary="a folder of TensorBoard's event files, by tags of SB3, CleanRL, ML-Agents, rsl_rl, RLlib and others",
        requires=("tensorboard",),
        extra="tensorboard",
    )
