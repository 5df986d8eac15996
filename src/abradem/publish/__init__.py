"""Publication of a study as a folder for an archive: data, data card, descriptors, figures, models.

`folder` builds the folder, `card` writes its README, `croissant` and `crate` the descriptors, and
`description` holds the texts that they share.
"""
