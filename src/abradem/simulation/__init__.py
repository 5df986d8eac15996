"""Batches of cases, and snapshots of single cases, as tables."""
