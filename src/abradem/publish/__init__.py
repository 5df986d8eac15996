"""A study as a folder for an archive: data, card, descriptors, figures, models."""
