"""What a summary holds beside its figures."""

RECORDS = {
    "experiment.toml",
    "results.json",
    "cells.csv",
    "curves.parquet",
    "summary.md",
}
