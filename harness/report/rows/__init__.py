"""What a report says, as text: what the terminal, the page and the summary share."""
