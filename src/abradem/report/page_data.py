"""Pages that hold their data and scripts, so that they open without a network."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from typing import Any

import numpy as np


def filled(page: str, texts: Mapping[str, str]) -> str:
    """Return a page with texts in place of its marks.

    Parameters
    ----------
    page : str
        HTML with marks such as ``{{title}}``.
    texts : mapping of str to str
        The text for each mark, in the order of the marks. Marks within texts stay as they are.

    Raises
    ------
    ValueError
        If the page lacks a mark.
    """
    done = ""
    for name, text in texts.items():
        before, found, page = page.partition("{{" + name + "}}")
        if not found:
            raise ValueError(f"page.html: lacks {{{{{name}}}}}")
        done += before + text
    return done + page


def data_in_script(data: Any) -> str:
    """JSON of which no text can end the script element that holds it."""
    return json.dumps(data, allow_nan=False).replace("<", "\\u003c")


def in_script(text: str) -> str:
    """JavaScript that cannot end the script element that holds it."""
    return text.replace("</script", "<\\/script")


def stored(array: np.ndarray) -> dict[str, Any]:
    """An array as text: little-endian numbers in base64, their type and the shape."""
    kind = "f4" if array.dtype == np.float32 else "f8"
    numbers = np.ascontiguousarray(array, dtype=f"<{kind}")
    text = base64.b64encode(numbers.tobytes()).decode("ascii")
    return {"type": kind, "shape": list(array.shape), "text": text}
