"""Display names for figures, tables and the report, in `labels`."""
