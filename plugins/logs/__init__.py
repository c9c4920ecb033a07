"""Built-in formats of logs."""

import harness


@harness.hookimpl
def register_logs(register: harness.Register) -> None:
    """Announce the built-in formats."""
    register("cell", "harness.record.cell_log:CellLog", summary="what a cell of an arm leaves: trace.parquet")
    register(
        "monitor",
        "harness_plugins.logs.monitor:Monitor",
        summary="stable-baselines3's Monitor and Gymnasium's old one: monitor.csv, a row is an episode",
    )
    register("steps-csv", "harness.score.csv_steps:StepsCsv", summary="CSV with a column 'reward', a row for each step")
