"""What a training has learned so far, in words: for the line of a running cell, and for ``harness status``."""


def learned_texts(success: float | None, mean: float | None) -> list[str]:
    """The share of episodes that reached the target and what they were paid, as far as they are known."""
    return [text for text in (success_text(success), return_text(mean)) if text]


def success_text(success: float | None) -> str:
    """As ``success 64 %``; empty before an episode has ended."""
    return "" if success is None else f"success {100 * success:.0f} %"


def return_text(mean: float | None) -> str:
    """As ``return 31.2``, in eight characters at most behind the word; empty before an episode has ended."""
    if mean is None:
        return ""
    return f"return {mean:,.0f}" if 1e3 <= abs(mean) < 1e6 else f"return {mean:.3g}"
