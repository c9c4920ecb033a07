"""What recorded trainings in any env say, as a terminal and a page show it."""
