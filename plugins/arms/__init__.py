"""Parts of simulators whose engine steps one arm at a time. Each arm has a world of its own."""
