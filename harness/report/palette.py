"""The colours and the letters of every figure."""

BLUE, VERMILION = "#0072B2", "#D55E00"
"""For baseline and proposed; apart for every kind of colour vision (Okabe and Ito), and in grey."""
GREY, GREEN = "#767676", "#009E73"
"""For ruler and behaviour; their rows are named too. Random actions are grey."""
INK, GRID = "#1a1a1a", "#e3e3e3"
