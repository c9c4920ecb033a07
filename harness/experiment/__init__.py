"""An experiment's cells, done: from what a user asks for to the folder of each cell."""
