"""The gallery page of the documentation, with every figure of a study at reduced size.

``python -m abradem.figures.gallery_page results/paper`` writes docs/gallery.md and its images from
the figures of a study. Images of figures that the study lacks are left unchanged.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path

from PIL import Image
from PIL.PngImagePlugin import PngInfo

from abradem.figures.captions import caption_of
from abradem.figures.catalogue import FIGURES, groups
from abradem.store.files import replacing, write_text
from abradem.words.escaping import for_markdown

WIDTH = 760
"""Width of the images, pixels."""

COLOURS = 128
"""Number of colours of the images: sufficient for charts, with a third of the file size."""


def shrink(source: Path, target: Path) -> None:
    """Write a copy of a picture and its caption at the width of the page, with few colours."""
    metadata = PngInfo()
    if text := caption_of(source):
        metadata.add_itxt("Description", text)
    with Image.open(source) as picture:
        height = round(picture.height * min(1.0, WIDTH / picture.width))
        width = min(WIDTH, picture.width)
        small = picture.convert("RGB").resize((width, height), Image.Resampling.LANCZOS)
    with replacing(target) as sink:
        few = small.quantize(COLOURS, dither=Image.Dither.NONE)
        few.save(sink, format="png", optimize=True, pnginfo=metadata)


def page(names: set[str], captions: Mapping[str, str] | None = None) -> str:
    """Markdown of the gallery.

    Parameters
    ----------
    names : set of str
        Figures with an image; the others are left out.
    captions : mapping of str to str, optional
        What the captions of figures say of this study.
    """
    lines = [
        "# Gallery",
        "",
        "The figures of a study at reduced size. `results/<study>/figures/` contains each as PDF",
        "and PNG at the width of a journal's column or page. `make run` makes all of them; the",
        "figures of verification and performance require an earlier `make verify` and",
        "`benchmarks/cost.py`. `snakemake movie` makes the film whose last frame is shown at the",
        "end (a few minutes; needs `pip install -e '.[movie]'`), `snakemake vtk` writes files for",
        "ParaView, and `snakemake paper` typesets `paper/main.tex`, an example of a text that",
        "includes figures, tables and numbers.",
        "",
    ]
    for group, figures in groups().items():
        shown = {name: entry for name, entry in figures.items() if name in names}
        if shown:
            lines += [f"## {group}", ""]
        for name, entry in shown.items():
            lines += [entry.full_caption.replace("``", "`"), ""]
            lines += [f"![{entry.label}](images/{name}.png)", ""]
            if text := (captions or {}).get(name):
                lines += [for_markdown(text), ""]
    if FILM in names:
        lines += ["## Film", "", "Wear of plates at three angles, on the same scale:", ""]
        lines += [f"![Wear of plates at three angles](images/{FILM}.png)", ""]
    return "\n".join(lines)


FILM = "film"


def main(arguments: list[str], root: Path = Path(".")) -> int:
    """Write the page and its images from the folder of a study, the only argument."""
    if len(arguments) != 1 or not Path(arguments[0], "figures").is_dir():
        print("usage: python -m abradem.figures.gallery_page results/<study>", file=sys.stderr)
        return 2
    study, images = Path(arguments[0]), root / "docs" / "images"
    wanted = {name: study / "figures" / f"{name}.png" for name in FIGURES}
    wanted[FILM] = study / "movie" / "wear.png"
    for name, path in wanted.items():
        if path.is_file():
            shrink(path, images / f"{name}.png")
    names = {name for name in wanted if (images / f"{name}.png").is_file()}
    captions = {name: caption_of(images / f"{name}.png") for name in names}
    write_text(page(names, captions), root / "docs" / "gallery.md")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
