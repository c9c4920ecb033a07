"""Experiments as reports are tried with."""

from tests.report.conftest import build

__all__ = ["build"]
