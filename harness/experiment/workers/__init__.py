"""The processes that do orders: the orders they get, what they answer, and how they are ended."""
