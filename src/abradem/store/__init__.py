"""Files that are complete or absent, tables whose columns have units, and locks."""
