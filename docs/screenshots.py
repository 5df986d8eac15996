"""Pictures of the explorer and of the scene in 3-D, as Chromium shows them, for the docs.

``python docs/screenshots.py results/paper`` writes ``docs/images/explorer.png`` and ``scene.png``
of the pages in the results of a study. It needs what the tests of the pages need: Debian's
chromium with its driver.
"""

import io
import sys
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from browser import opened, settle  # noqa: E402, from the folder above

SIZES = {"explorer": (1366, 1180), "scene": (1120, 760)}
"""Width and height of the pictures, pixels; the upper part of the explorer has the map."""


def picture(page: Path, size: tuple[int, int]) -> Image.Image:
    """The upper part of a page in a window of a size, once all is drawn."""
    with opened(page) as driver:
        screen = {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False}
        command = {"cmd": "Emulation.setDeviceMetricsOverride", "params": screen}
        driver.execute("executeCdpCommand", command)
        settle(driver)
        return Image.open(io.BytesIO(driver.get_screenshot_as_png())).convert("RGB")


def main() -> None:
    """Write the pictures of the pages that a study has."""
    if len(sys.argv) != 2:
        sys.exit("usage: python docs/screenshots.py results/STUDY")
    pages = {name: Path(sys.argv[1], f"{name}.html").resolve() for name in SIZES}
    found = {name: page for name, page in pages.items() if page.is_file()}
    if not found:
        sys.exit(f"{sys.argv[1]}: has neither explorer.html nor scene.html; run the study first")
    for name, page in found.items():
        picture(page, SIZES[name]).save(ROOT / f"docs/images/{name}.png", optimize=True)


if __name__ == "__main__":
    main()
