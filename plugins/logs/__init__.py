"""Built-in formats of logs."""

import harness


@harness.hookimpl
def register_logs(register: harness.Register) -> None:
    """Announce the built-in formats."""
    register(
        "recording", "harness_plugins.logs.recording:Recording", summary="steps of a training, by harness.RecordRewards"
    )
    register(
        "monitor",
        "harness_plugins.logs.monitor:Monitor",
        summary="stable-baselines3's Monitor and Gymnasium's old one: monitor.csv, a row is an episode",
    )
