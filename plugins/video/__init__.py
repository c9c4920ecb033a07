"""Films of recorded episodes, as GIF and MP4."""
