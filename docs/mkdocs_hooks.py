"""What the site has beside the pages of this folder: other pages, the tutorial and the reference.

Pages of other folders of the repository, such as README.md, are pages of the site as well, and
links are changed accordingly. Links to files that are no pages become their text. For every
package of abradem there is a page that mkdocstrings fills from its docstrings.
"""

import importlib.util
import json
import posixpath
import re
from pathlib import Path

from mkdocs.structure.files import File

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src/abradem"
ELSEWHERE = {
    "README.md": "overview.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changes.md",
    "results/README.md": "results.md",
    "benchmarks/README.md": "benchmarks.md",
    "tests/data/codes/README.md": "codes.md",
}
"""Pages outside this folder, and what the site calls them."""

LINK = re.compile(r"(?P<image>!?)\[(?P<text>[^\]]*)\]\((?P<target>[^)#\s]+)(?P<anchor>#[^)\s]*)?\)")


def packages() -> list[str]:
    """Names of the packages and of the modules at the root of abradem."""
    found = [path.parent.name for path in SOURCE.glob("*/__init__.py")]
    return sorted([*found, *(path.stem for path in SOURCE.glob("[!_]*.py"))])


def notebooks():
    """The module that makes a page of a notebook; this folder is no package."""
    spec = importlib.util.spec_from_file_location("notebooks", ROOT / "docs/notebooks.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def on_files(files, config):
    """Add the pages that this folder does not hold."""
    for path, uri in ELSEWHERE.items():
        text = (ROOT / path).read_text(encoding="utf-8")
        files.append(File.generated(config, uri, content=text))
    notebook = json.loads((ROOT / "docs/tutorial.ipynb").read_text(encoding="utf-8"))
    text, pictures = notebooks().page(notebook, "tutorial")
    for uri, content in {"tutorial.md": text, **pictures}.items():
        files.append(File.generated(config, uri, content=content))
    for name in packages():
        text = f"# abradem.{name}\n\n::: abradem.{name}\n"
        files.append(File.generated(config, f"reference/{name}.md", content=text))
    return files


def on_page_markdown(markdown, page, **_):
    """Change links between files of the repository to links between pages of the site."""
    uri = page.file.src_uri
    source = {site: path for path, site in ELSEWHERE.items()}.get(uri, f"docs/{uri}")

    def changed(link: re.Match) -> str:
        target = link["target"]
        if ":" in target:
            return link[0]
        path = posixpath.normpath(posixpath.join(posixpath.dirname(source), target))
        if path == "docs/tutorial.ipynb":
            path = "docs/tutorial.md"
        place = ELSEWHERE.get(path, path.removeprefix("docs/") if path.startswith("docs/") else "")
        if place:
            relative = posixpath.relpath(place, posixpath.dirname(uri) or ".")
            return f"{link['image']}[{link['text']}]({relative}{link['anchor'] or ''})"
        # What does not exist stays, so that the check of the links finds it.
        return link["text"] if (ROOT / path).exists() else link[0]

    return LINK.sub(changed, markdown)
