"""What a library may do with a file."""

import os


def end(word):
    """Never return, fill the memory, end the process, or raise."""
    if word == "loop":
        while True:
            pass
    if word == "fill":
        return [bytearray(2**26) for _ in range(1_000)]
    if word == "abort":
        os.abort()
    return 1 / 0
