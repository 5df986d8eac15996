"""The files of the explorer and of the scene that are no modules."""

from __future__ import annotations

from pathlib import Path

_HERE = Path(__file__).parent

FRAME_FILES = tuple(_HERE / "page_frame" / name for name in ("frame.html", "frame.css"))
"""What the pages have in common: head, order of the scripts, and look."""

EXPLORER_FILES = tuple(
    _HERE / "explorer_page" / name for name in ("page.html", "style.css", "model.js", "page.js")
)
"""Content, look, model, and what is seen and moved."""

SCENE_FILES = tuple(_HERE / "scene_page" / name for name in ("page.html", "style.css", "page.js"))
"""Content, look, and what is seen and moved."""
