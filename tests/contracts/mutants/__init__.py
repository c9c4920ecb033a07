"""Mutants: what is changed in something sound, and the check that it has to fail.

Each module has the rows of a kind: what is changed, in words, then the name of the check and the plugin, and where an
exception is right or a sentence matters the words that it has.
"""


def mutant(sound, **changed):
    """What is sound but for some methods or class attributes."""
    return type("Mutant", (sound,), changed)()
