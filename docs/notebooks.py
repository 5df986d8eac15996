"""Runs a notebook and stores what its cells print, without Jupyter; and makes a page of it.

``python docs/notebooks.py docs/tutorial.ipynb`` runs the cells in the folder of the repository and
writes their outputs into the file. Jupyter opens the same file.
"""

import ast
import base64
import contextlib
import io
import json
import os
import sys
import traceback
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
IMAGE, TEXT = "image/png", "text/plain"
DPI = 110


def run(notebook: dict) -> dict:
    """Run the code cells of a notebook one after the other, and return it with their outputs."""
    names: dict = {"__name__": "__main__"}
    count = 0
    cells = []
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            count += 1
            outputs = _outputs("".join(cell["source"]), names, f"cell {count}")
            cell = {**cell, "execution_count": count, "outputs": outputs}
        cells.append(cell)
    return {**notebook, "cells": cells}


def _outputs(source: str, names: dict, where: str) -> list[dict]:
    """What a cell prints, and the value of its last line."""
    tree = ast.parse(source, where)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed, value = io.StringIO(), None
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, where, "exec"), names)
        if last is not None:
            value = eval(compile(ast.Expression(last.value), where, "eval"), names)
    outputs = []
    if text := printed.getvalue():
        outputs.append({"output_type": "stream", "name": "stdout", "text": _lines(text)})
    if value is not None:
        outputs.append({"output_type": "display_data", "metadata": {}, "data": _data(value)})
    return outputs


def _data(value) -> dict:
    if hasattr(value, "savefig"):
        picture = io.BytesIO()
        # Without the version of the library, so that equal pictures are equal bytes.
        value.savefig(picture, format="png", dpi=DPI, metadata={"Software": None})
        return {IMAGE: base64.b64encode(picture.getvalue()).decode("ascii")}
    return {TEXT: _lines(repr(value))}


def _lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)


def page(notebook: dict, name: str) -> tuple[str, dict[str, bytes]]:
    """A notebook as Markdown, and its pictures by their file names."""
    parts, pictures = [], {}
    for cell in notebook["cells"]:
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(source)
            continue
        parts.append(f"```python\n{source}\n```")
        for output in cell["outputs"]:
            data = output.get("data", {})
            if IMAGE in data:
                file = f"images/{name}_{len(pictures)}.png"
                pictures[file] = base64.b64decode(data[IMAGE])
                parts.append(f"![output of the cell above]({file})")
            else:
                text = "".join(output.get("text") or data[TEXT]).rstrip("\n")
                parts.append(f"```text\n{text}\n```")
    return "\n\n".join(parts) + "\n", pictures


def main(path: Path) -> int:
    """Run a notebook and store its outputs; returns the exit code."""
    notebook = json.loads(path.read_text(encoding="utf-8"))
    os.chdir(ROOT)
    try:
        done = run(notebook)
    except Exception:
        traceback.print_exc()
        return 1
    text = json.dumps(done, indent=1, ensure_ascii=False)
    path.write_text(f"{text}\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve()))
