"""The pages: HTML files that open anywhere, offline."""
