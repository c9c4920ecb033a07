"""The processes that do orders: what they are told, what they answer, and how they are ended."""
