"""The replay: recorded episodes in 3D, a part of a page."""
