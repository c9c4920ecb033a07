"""What a metric must satisfy."""
