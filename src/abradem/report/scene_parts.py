"""The files of the page of a scene that are no modules."""

from __future__ import annotations

from pathlib import Path

SCENE_FILES = tuple(
    Path(__file__).with_name("scene_page") / name for name in ("page.html", "style.css", "page.js")
)
"""Page, look, and what is seen and moved."""
