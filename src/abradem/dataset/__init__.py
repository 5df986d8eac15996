"""The data set: features, the join of cases with their wear rates, and external tables."""
