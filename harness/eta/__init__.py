"""Numbers in, numbers and words out: the note's indices, their ratios, and how far these can be trusted."""
