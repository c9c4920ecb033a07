"""Whether rewards rank the episodes of a data set as success does."""
