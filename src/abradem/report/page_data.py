"""Pages that hold their data and scripts, so that they open without a network."""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from abradem.report.page_files import FRAME_FILES


def whole_page(
    title: str, files: Sequence[Path], data: Any, scripts: Sequence[Sequence[str]]
) -> str:
    """Return a page with its data, plotly.js and its scripts.

    Parameters
    ----------
    title : str
    files : sequence of path
        Of `abradem.report.page_files`; page.html and style.css are content and look.
    data : Any
        Plain values; the page finds them in the element ``data``.
    scripts : sequence of sequence of str
        For each script element the texts in it: a name of ``files``, or JavaScript.
    """
    from plotly.offline import get_plotlyjs

    parts = {path.name: path.read_text(encoding="utf-8") for path in (*FRAME_FILES, *files)}
    texts = {
        "title": html.escape(title),
        "style": (parts["frame.css"] + parts["style.css"]).rstrip("\n"),
        "body": parts["page.html"].rstrip("\n"),
        "data": data_in_script(data),
        "plotly": in_script(get_plotlyjs()),
        "scripts": "\n".join(
            "<script>\n"
            + "\n".join(in_script(parts.get(one, one)) for one in script)
            + "\n</script>"
            for script in scripts
        ),
    }
    return filled(parts["frame.html"], texts)


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
            raise ValueError(f"frame.html: lacks {{{{{name}}}}}")
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
