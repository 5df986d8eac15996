"""The files of the explorer's page that are no modules."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).with_name("explorer_page")

FILES = tuple(FOLDER / name for name in ("page.html", "style.css", "model.js", "page.js"))
"""Page, look, model, and what is seen and moved."""
