"""The captions of the figures of a study, as their files hold them."""

from __future__ import annotations

from pathlib import Path

from abradem.words.escaping import for_rst


def caption_of(path: str | Path) -> str:
    """The caption that `abradem.figures.style.save` wrote into a PNG file.

    Parameters
    ----------
    path : path-like
        A figure in any format; its caption is read from the PNG file beside it.

    Returns
    -------
    str
        One line of plain text; "" if the file is missing or holds none.
    """
    # Imported here, as the workflow loads this module at every start.
    from PIL import Image

    file = Path(path).with_suffix(".png")
    if not file.is_file():
        return ""
    with Image.open(file) as picture:
        return str(picture.info.get("Description", ""))


def caption_in_rst(path: str | Path) -> str:
    """`caption_of` as reStructuredText."""
    text = caption_of(path)
    return for_rst(text) if text else ""
