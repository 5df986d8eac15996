"""Plain text as the text of another format, with nothing in it that the format would act on.

One function for each format. A text is escaped once, where it enters a file of that format. All
functions return one line: white space and line breaks become single blanks.
"""

from __future__ import annotations

import html
import re
import unicodedata
from typing import Any

_PUNCTUATION = re.compile(r"""[!"#$%&'()*+,\-./:;<=>?@\[\\\]^_`{|}~•‣⁃]""")

_LATEX = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    **{char: f"\\{char}" for char in "&%$#_{}"},
}
_BIBTEX = {**_LATEX, "{": r"\textbraceleft{}", "}": r"\textbraceright{}"}
"""BibTeX counts braces even after a backslash."""

_MARKDOWN = re.compile(
    r"[\\`*_{}\[\]<>#|~&$^@]"  # markup, tables, formulas, entities, addresses
    r"|:(?=//)|(?<=www)\."  # links without markup
    r"|^[-+=]|(?<=^\d)[.)]|(?<=^\d\d)[.)]"  # lists and rules at the start of a line
)


def _line(text: str) -> str:
    return " ".join(text.split())


def for_rst(text: str) -> str:
    """Return ``text`` for reStructuredText.

    Every ASCII punctuation mark and every bullet is escaped: docutils acts on each of them, at
    the start of a line, beside a blank or within an address.
    """
    shown = _PUNCTUATION.sub(r"\\\g<0>", _line(text))
    # A line of nothing but backslashes would be a rule; an escaped blank is nothing.
    return shown if shown.strip("\\") else f"\\ {shown}"


def data_for_rst(value: Any) -> Any:
    """Return plain data with all texts in it, also the names of keys' values, for a template.

    The keys of mappings that a template prints are texts as well, so `for_rst` is applied to a
    key if it is not a plain word.
    """
    if isinstance(value, dict):
        return {
            key if re.fullmatch(r"\w+", str(key), re.ASCII) else for_rst(str(key)): data_for_rst(
                inner
            )
            for key, inner in value.items()
        }
    if isinstance(value, (list, tuple)):
        return [data_for_rst(inner) for inner in value]
    return for_rst(value) if isinstance(value, str) else value


def for_latex(text: str) -> str:
    """Return ``text`` for LaTeX."""
    return "".join(_LATEX.get(char, char) for char in _line(text))


def for_bibtex(text: str) -> str:
    """Return ``text`` for the value of a field of BibTeX that is enclosed in braces."""
    return "".join(_BIBTEX.get(char, char) for char in _line(text))


def names_for_bibtex(names: list[str] | tuple[str, ...]) -> str:
    """Return names for the field ``author``.

    A name with parts that BibTeX would take for several names, or for more than last and first
    name, is kept whole in braces.
    """
    shown = []
    for name in names:
        words = _line(name).lower().split(" ")
        whole = "and" in words or words == ["others"] or name.count(",") > 1
        shown.append(f"{{{for_bibtex(name)}}}" if whole else for_bibtex(name))
    return " and ".join(shown)


def for_mathtext(text: str) -> str:
    """Return ``text`` for matplotlib, where dollars enclose formulas."""
    return _line(text).replace("$", r"\$")


_NAMES = {
    "alpha": "α", "eta": "η", "mu": "µ", "nu": "ν", "rho": "ρ", "theta": "θ", "varphi": "φ",
    "xi": "ξ", "ln": "ln ", "cos": "cos ", "times": " × ", "leq": "≤", "geq": "≥", "approx": "≈",
}  # fmt: skip
_RAISED = str.maketrans("0123456789-+*", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺*")


def from_mathtext(text: str) -> str:
    """Return a text for matplotlib as plain text: formulas between dollars in Unicode.

    Raised numbers become superscripts, lowered signs follow an underscore: ``$v_y$`` is v_y.
    """
    parts = re.split(r"(?<!\\)\$", text)
    parts[1::2] = map(_formula, parts[1::2])
    return unicodedata.normalize("NFC", _line("".join(parts).replace(r"\$", "$")))


def _formula(tex: str) -> str:
    shown = re.sub(r"\\(?:mathrm|bf|mathbf)\s?", "", tex)
    shown = re.sub(r"\\dot\s*(\w)", "\\1\u0307", shown)
    shown = re.sub(r"\\([A-Za-z]+)\s?", lambda one: _NAMES.get(one[1], one[1]), shown)
    shown = re.sub(
        r"\^(?:\{([^}]*)\}|(.))", lambda one: (one[1] or one[2]).translate(_RAISED), shown
    )
    return shown.replace("{", "").replace("}", "").replace("\\", "")


def for_html(text: str) -> str:
    """Return ``text`` for HTML, also within the quotes of an attribute."""
    return html.escape(_line(text), quote=True)


def for_markdown(text: str) -> str:
    """Return ``text`` for Markdown (CommonMark and its tables)."""
    return _MARKDOWN.sub(r"\\\g<0>", _line(text))
