"""What makes a task harder than its target: noise, delays, obstacles, and arms that differ from the drawing."""
