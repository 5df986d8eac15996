"""Escaped text is the text again for a reader of its format, and nothing but text."""

import html.parser
import re
from pathlib import Path

import docutils.core
import docutils.nodes
import jinja2
import pytest
from docutils.utils import SystemMessage
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.text import Text as FigureText

from abradem.words import escaping

ROOT = Path(__file__).parents[2]

HOSTILE = [
    "my_table_.csv",
    "Wear by {DEM}",
    "{",
    "}} {{ 7 * 7 }} {% raw %}",
    "`link <https://evil.example>`_",
    "https://evil.example/a_b?c=d&e#f",
    "www.evil.example and mail@evil.example",
    ".. include:: /etc/passwd",
    ".. raw:: html",
    "|substituted| *emphasis* **strong** ``literal``",
    ":field: value",
    "- item",
    "1. item",
    "(a) item",
    "====",
    "::",
    "\\",
    "\\\\\\\\",
    "\\input{/etc/passwd}",
    "50 % of $x^2$ & #1 ~ <tag> \"quoted\" 'single'",
    "a $ lonely dollar",
    "$$$",
    "<script>alert(1)</script>",
    "&lt; &amp; &#60;",
    "![image](x.png) [link](y) <z@example.org>",
    "# heading",
    "> quotation",
    "| cell | cell |",
    "--- +++ === ***",
    "```",
    "trailing_",
    "_leading __dunder__ x__",
    "[1]_ [#]_ [*]_ anonymous__",
    "Ångström, 水, Müller–Straße",
    "C:\\temp\\new_file_.csv",
    ">>> doctest",
    "~a^b",
    "• item",
]
PRINTABLE = st.text(
    st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Zl", "Zp", "Zs"))
    | st.sampled_from(" _`*|\\{}<>$&%#[]:.-"),
    min_size=1,
    max_size=40,
).filter(lambda text: text.strip())
quickly = settings(max_examples=60, derandomize=True, database=None, deadline=None)


def line(text):
    return " ".join(text.split())


def assert_rst(text):
    """A paragraph, and a cell of a table, that hold the text and nothing else."""
    shown = escaping.for_rst(text)
    source = f"{shown}\n\n.. list-table::\n\n   * - {shown}\n     - before {shown} after\n"
    tree = docutils.core.publish_doctree(
        source, settings_overrides={"report_level": 1, "halt_level": 1, "warning_stream": False}
    )
    kinds = {type(node) for node in tree.findall()}
    assert not kinds & {
        docutils.nodes.reference, docutils.nodes.problematic, docutils.nodes.system_message,
        docutils.nodes.emphasis, docutils.nodes.strong, docutils.nodes.literal,
        docutils.nodes.raw, docutils.nodes.bullet_list, docutils.nodes.enumerated_list,
        docutils.nodes.section, docutils.nodes.substitution_reference,
    }  # fmt: skip
    paragraphs = [node.astext() for node in tree.findall(docutils.nodes.paragraph)]
    assert paragraphs == [line(text), line(text), f"before {line(text)} after"]


@pytest.mark.parametrize("text", HOSTILE)
def test_text_in_rst_is_text(text):
    assert_rst(text)


@quickly
@given(PRINTABLE)
def test_any_text_in_rst_is_text(text):
    assert_rst(text)


def decoded(text, commands):
    """What TeX prints: escaped characters and commands of one character."""
    names = {command: char for char, command in commands.items()}
    pattern = re.compile(r"\\(?:[a-z]+\{\}|[&%$#_{}])|.", re.DOTALL)
    out = []
    for token in pattern.findall(text):
        assert token in names or token not in set("\\&%$#_{}~^"), f"{token!r} in {text!r}"
        out.append(names.get(token, token))
    return "".join(out)


LATEX = {
    **{char: f"\\{char}" for char in "&%$#_{}"},
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
    "<": r"\textless{}", ">": r"\textgreater{}", "|": r"\textbar{}",
}  # fmt: skip
BIBTEX = {**LATEX, "{": r"\textbraceleft{}", "}": r"\textbraceright{}"}


def assert_balanced(text):
    """As BibTeX counts: every brace, also one after a backslash."""
    depth = 0
    for char in text:
        depth += (char == "{") - (char == "}")
        assert depth >= 0, text
    assert depth == 0, text


@pytest.mark.parametrize("text", HOSTILE)
def test_text_in_latex_and_bibtex_is_text(text):
    assert decoded(escaping.for_latex(text), LATEX) == line(text)
    shown = escaping.for_bibtex(text)
    assert decoded(shown, BIBTEX) == line(text)
    assert_balanced(shown)


@quickly
@given(PRINTABLE)
def test_any_text_in_latex_and_bibtex_is_text(text):
    assert decoded(escaping.for_latex(text), LATEX) == line(text)
    assert decoded(escaping.for_bibtex(text), BIBTEX) == line(text)
    assert_balanced(escaping.for_bibtex(text))


def test_names_that_bibtex_would_divide_are_kept_whole():
    names = ["Ada Lovelace", "Rock and Roll Ltd.", "Doe, Jr., John, MD", "others", "Sand & Son"]
    assert escaping.names_for_bibtex(names) == (
        r"Ada Lovelace and {Rock and Roll Ltd.} and {Doe, Jr., John, MD} and {others} "
        r"and Sand \& Son"
    )


class _Reader(html.parser.HTMLParser):
    def __init__(self):
        super().__init__(convert_charrefs=True)
        self.text, self.tags = "", []

    def handle_data(self, data):
        self.text += data

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, attributes))


@pytest.mark.parametrize("text", HOSTILE)
def test_text_in_html_is_text_also_in_an_attribute(text):
    shown = escaping.for_html(text)
    reader = _Reader()
    reader.feed(f'<p title="{shown}">{shown}</p>')
    reader.close()
    assert reader.tags == [("p", [("title", line(text))])]
    assert reader.text == line(text)


MARKDOWN_ACTS_ON = re.compile(r"(?<!\\)(?:\\\\)*([`*_{}\[\]<>#|~&$^@]|(?<=www)\.|:(?=//))")


@pytest.mark.parametrize("text", HOSTILE)
def test_text_in_markdown_is_text(text):
    shown = escaping.for_markdown(text)
    # Every ASCII punctuation mark may be escaped in CommonMark; no other character is.
    assert re.sub(r"\\([!-/:-@\[-`{-~])", r"\1", shown) == line(text)
    assert not re.search(MARKDOWN_ACTS_ON, shown)
    assert not re.match(r"[-+=>#]|\d+[.)]", shown)


@pytest.mark.parametrize("text", HOSTILE)
def test_text_in_a_figure_is_text(text):
    shown, is_formula = FigureText()._preprocess_math(escaping.for_mathtext(text))
    assert not is_formula
    assert shown == line(text)


def test_data_for_templates_keep_their_structure_and_numbers():
    data = {"a_b": ["x_", 1.5, None, True], "no wear: <b>": {"k": ("y`",)}}
    assert escaping.data_for_rst(data) == {
        "a_b": [r"x\_", 1.5, None, True], r"no wear\: \<b\>": {"k": [r"y\`"]},
    }  # fmt: skip


SUMMARY = {
    "external": "x", "cases": 24, "target": "wear_total_mean", "wear_range": [1e-9, 2e-9],
    "misprints": None,
    "models": [{"model": "ga_ann", "r2": 0.5, "lower": None, "upper": 0.6, "number": None,
                "basis": "fixed_split"}],
}  # fmt: skip


@pytest.mark.parametrize("text", HOSTILE)
@pytest.mark.parametrize("page", ["workflow", "external"])
def test_the_pages_of_the_report_show_names_of_files_as_they_are(page, text):
    """With the template, as Snakemake renders it; docutils says nothing about it."""
    from abradem.config import Config

    resolved = Config.model_validate({"study": "my_study_", "dataset": {"external": text}})
    snakemake = {
        "params": {"repeated": "2 rows repeat the quantities of another (rows 1+2)"},
        "config": {
            "study": "my_study_",
            "summary": escaping.data_for_rst({**SUMMARY, "external": text, "misprints": [text]}),
            "resolved": escaping.data_for_rst(resolved.model_dump(mode="json")),
            "recorded": escaping.data_for_rst({"versions": {"scikit-learn": "1.9_"}}),
            "run_times": escaping.data_for_rst(
                [{"rule": "ga_ann_", "jobs": 1, "seconds": 1.0, "longest": 1.0}]
            ),
            "verification": {},
        },
    }
    template = (ROOT / "workflow" / "report" / f"{page}.rst").read_text(encoding="utf-8")
    environment = jinja2.Environment(trim_blocks=True, lstrip_blocks=True)
    source = environment.from_string(template).render(snakemake=snakemake)
    try:
        tree = docutils.core.publish_doctree(
            source, settings_overrides={"report_level": 1, "halt_level": 1, "warning_stream": False}
        )
    except SystemMessage as error:
        pytest.fail(f"{error}\n{source}")
    assert line(text) in line(tree.astext())
    assert not list(tree.findall(docutils.nodes.reference))


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        (r"$R^2$ of $\ln y$, $v_y$ = −3 m/s", "R² of ln y, v_y = −3 m/s"),
        (r"$p < 10^{-4}$; $\varphi$ = 45°", "p < 10⁻⁴; φ = 45°"),
        (r"5.05 $\times 10^{-9}$ 1/Pa,  $\dot h$ and $G^*$", "5.05 × 10⁻⁹ 1/Pa, ḣ and G*"),
        (r"costs \$5 $\mathrm{mm}$", "costs $5 mm"),
        ("no formula, 20 % of_it", "no formula, 20 % of_it"),
    ],
)
def test_formulas_of_figures_are_unicode_in_plain_text(text, plain):
    assert escaping.from_mathtext(text) == plain
