"""A package as authors wrote them for version 0.1.0: nothing in it was changed since."""
