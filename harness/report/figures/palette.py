"""The colours of pages, figures and films: one style sheet, and its light screen for what has no style sheet.

The ruler is ochre and the behaviour blue, wherever they are drawn or named. The baseline is grey, the proposed reward
violet. Green and red are kept for better and worse.
"""

import re
from functools import cache
from pathlib import Path

STYLE = Path(__file__).parent / "palette.css"
CHART = Path(__file__).parent / "chart.css"
SIDES = ("baseline", "proposed", "orange", "sky")
"""The names of the colours of policies beside one another: the baseline, the proposed reward, others."""
COLOUR = re.compile(r"--([\w-]+): ([^;]+);")


@cache
def light_colours() -> dict[str, str]:
    """Every colour of a light screen, such as ``#1f5fbf``, by its name in the style sheet, without the dashes."""
    return dict(COLOUR.findall(STYLE.read_text(encoding="utf-8").partition("}")[0]))


def chart_style() -> str:
    """The page's style rules for charts, with the colours of the light screen in place of their names."""
    colours, rules = light_colours(), CHART.read_text(encoding="utf-8")
    return re.sub(r"var\(--([\w-]+)\)", lambda name: colours[name[1]], rules)
