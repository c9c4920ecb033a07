"""What a summary holds beside its figures."""

RECORDS = {
    "experiment.toml",
    "results.json",
    "cells.csv",
    "curves.parquet",
    "runs.parquet",
    "figures.json",
    "summary.md",
}
