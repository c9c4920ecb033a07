"""The colours of a film: those of the page on a light screen."""

BLUE, VERMILION = "#0072B2", "#D55E00"
"""For baseline and proposed; apart for every kind of colour vision (Okabe and Ito), and in grey."""
GREY, GREEN = "#767676", "#009E73"
"""For random actions, and for what is beside the two."""
INK = "#1a1a1a"
