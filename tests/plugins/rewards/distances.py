"""Distances of episodes, drawn."""

from hypothesis import strategies as st

METRES = st.integers(0, 3072).map(lambda n: n / 1024)
"""Sums, differences and doubles of these are exact."""
DISTANCES = st.lists(METRES, min_size=2, max_size=30)
GAINS = st.floats(0.01, 10.0)
