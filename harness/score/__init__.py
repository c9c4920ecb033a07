"""Recorded runs, paid again under other rewards."""

from functools import partial
from typing import TYPE_CHECKING

from harness.face import lookup

if not TYPE_CHECKING:
    __getattr__ = partial(lookup, __name__)
