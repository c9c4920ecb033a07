"""Arms of engines that step one arm at a time: each in a world of its own, ideal drives or limited ones."""
