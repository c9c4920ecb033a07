"""Building blocks for plugin authors, which the core itself does not use: the flat modules have their names."""

from functools import partial

from harness.face import lookup

__getattr__ = partial(lookup, __name__)
