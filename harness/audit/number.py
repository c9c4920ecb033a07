"""Numbers as an audit prints them."""


def number(value: float) -> str:
    """Three significant digits, and no exponent where that is readable."""
    text = f"{value:.3g}" if abs(value) >= 1e-9 else "0"
    return f"{value:,.0f}" if "e+" in text and abs(value) < 1e9 else text
