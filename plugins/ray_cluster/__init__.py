"""The executor ``ray``: how it reaches a cluster, which nodes it takes, and what is done on them."""
