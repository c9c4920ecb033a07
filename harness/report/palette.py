"""The colours and the letters of every figure."""

BLUE, VERMILION = "#0072B2", "#D55E00"
"""For baseline and proposed; apart for every kind of colour vision (Okabe and Ito), and in grey."""
GREY, GREEN = "#767676", "#009E73"
"""For ruler and behaviour; their rows are named too. Random actions are grey."""
INK, GRID = "#1a1a1a", "#e3e3e3"
FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif"


def faint(colour: str) -> str:
    """The colour, as ``#rrggbb``, for areas that lines cross."""
    red, green, blue = (int(colour[at : at + 2], 16) for at in (1, 3, 5))
    return f"rgba({red}, {green}, {blue}, 0.18)"
