"""What a reader of logs must satisfy."""
