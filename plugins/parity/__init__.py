"""How far simulators differ that are told the same."""
