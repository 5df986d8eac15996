"""Flow charts: generation of the data, set-up of a simulation, and rules of the workflow."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch, Patch, Polygon
from matplotlib.path import Path as Outline

from abradem.dem.model import Setup
from abradem.figures import style
from abradem.words.escaping import for_mathtext

WORDS = {
    "sample": ("draw parameter sets", "one table for each block of cases"),
    "join_cases": ("join the parameter sets", "cases.parquet"),
    "simulate": ("simulate", "worn volume over time, wear maps"),
    "wear_rates": ("wear rates", "steady slope, standard error, flags"),
    "failures": ("failures", "cases without a rate, reasons"),
    "dataset": ("data set", "X1 to X20 and the wear depth rates"),
}
"""Task and output of the rules that lead to the data set."""

LANES = (
    ("cases, simulation", ("sampling", "simulation")),
    ("wear, data set", ("wear", "dataset", "external")),
    ("learning", ("baselines", "physical", "learning")),
)
"""Titles of the columns of the workflow figure and the stages in each."""

LAST_LANE = "figures, tables"

_LANE_COLOURS = {
    **dict(zip(dict(LANES), (style.BLUE, style.GREEN, style.RED), strict=True)),
    LAST_LANE: style.GREY,
}
"""Colour of the boxes of a stage and of the lines that lead from them."""

_METHODS = {
    "lhs": "Latin hypercube",
    "sobol": "Sobol sequence",
    "uniform": "independent",
}
_WIDE = 2.2
"""Width of a box that is alone on its level, inches."""

_TINT = {"data": "#E8F1F8", "step": "white", "choice": "#FDF3E0"}


def draw_generation(graph: pd.DataFrame, study: Mapping, setup: Mapping | None) -> Figure:
    """Draw `generation_figure` from the plain values of a `Setup`."""
    return generation_figure(graph, study, None if setup is None else Setup.from_dict(setup))


def generation_figure(
    graph: pd.DataFrame, study: Mapping[str, object], setup: Setup | None
) -> Figure:
    """Flow charts of the generation of the data and of the set-up of each simulation.

    Parameters
    ----------
    graph : pandas.DataFrame
        From `abradem.running.rule_graph.rule_graph`.
    study : mapping
        cases, blocks, jobs, method, seed, and ``external``, the path of an external table or None.
    setup : Setup or None
        None if nothing is simulated; the second chart is then left out.
    """
    needs = needs_of(graph)
    chain = _way_to("dataset", needs)
    with style.style():
        height = 5.4 if setup else 1.1 + 0.75 * (1 + max(chain.values()))
        figure = Figure(figsize=(style.PAGE, height))
        foot = 0.25 / height
        left = _canvas(figure, (0.0, foot, 0.44, 1.0 - foot))
        _generation(left, needs, chain, study)
        kinds = {"data": "files", "step": "step"}
        if setup is not None:
            _simulation(_canvas(figure, (0.46, foot, 0.54, 1.0 - foot)), setup)
            kinds["choice"] = "decision"
        figure.legend(
            handles=[
                Patch(facecolor=_TINT[kind], edgecolor=style.BLUE, lw=0.8, label=words)
                for kind, words in kinds.items()
            ],
            loc="lower center",
            ncols=3,
        )
    return figure


def workflow_figure(graph: pd.DataFrame) -> Figure:
    """All rules of the study and their dependencies, from left to right by stage.

    Parameters
    ----------
    graph : pandas.DataFrame
        From `abradem.running.rule_graph.rule_graph`.

    Returns
    -------
    matplotlib.figure.Figure
        Lines that cross a column have their own place in it, so that none runs behind a box.
    """
    needs = needs_of(graph)
    used = set().union(*needs.values())
    alone = sorted(rule for rule, near in needs.items() if not near and rule not in used)
    drawn = graph[~graph["rule"].isin(alone)]
    linked = {rule: near for rule, near in needs.items() if rule not in alone}
    titles, columns = zip(*_columns(drawn, linked), strict=True)
    layers, links = _with_passages(columns, linked)
    heights = _places(layers, links)
    with style.style():
        top = max(y for layer in heights for y in layer.values())
        bottom = min(y for layer in heights for y in layer.values())
        figure = Figure(figsize=(style.PAGE, top - bottom + 0.85))
        panel = _canvas(figure, (0.0, 0.0, 1.0, 1.0))
        widths = [max(_box_width(rule) for rule in rules) for rules in columns]
        gap = (style.PAGE - 0.1 - sum(widths)) / max(len(widths) - 1, 1)
        lefts = [0.05 + sum(widths[:n]) + n * gap for n in range(len(widths))]
        lift = 0.42 - bottom
        for number, title in enumerate(titles):
            if title not in titles[:number]:
                last = len(titles) - 1 - titles[::-1].index(title)
                at_edge = last == len(titles) - 1
                right = lefts[last] + widths[last]
                panel.text(
                    right if at_edge else 0.5 * (lefts[number] + right),
                    top + lift + 0.28, title, ha="right" if at_edge else "center", va="center",
                    fontsize=7.5, fontweight="bold", color=_LANE_COLOURS[title],
                )  # fmt: skip
        shades = {
            rule: _LANE_COLOURS[title]
            for title, rules in zip(titles, columns, strict=True)
            for rule in rules
        }
        for early, late, column in links:
            # A line starts at the right edge of a box, or of the column for a passage.
            start = lefts[column] + (
                widths[column] if _is_passage(early) else 0.5 * widths[column]
                + 0.5 * _box_width(early)
            )  # fmt: skip
            end = lefts[column + 1] + (
                0.0 if _is_passage(late) else 0.5 * widths[column + 1] - 0.5 * _box_width(late)
            )
            from_y, to_y = heights[column][early] + lift, heights[column + 1][late] + lift
            colour = shades[_maker(early)]
            if _is_passage(early):
                panel.plot([lefts[column], start], [from_y] * 2, color=colour, lw=0.8, alpha=0.7)
            _curve(panel, (start, from_y), (end, to_y), colour)
        for column, rules in enumerate(columns):
            for rule in rules:
                _box(
                    panel, lefts[column] + 0.5 * widths[column], heights[column][rule] + lift,
                    _box_width(rule), 0.17, _short(rule), edge=shades[rule],
                )  # fmt: skip
        style.caption(
            figure,
            f"{len(needs)} rules; colour: stage of the rule that makes the files; lines: "
            "dependencies, without those that follow from others"
            + (f"; not drawn, as they depend on no rule and no rule on them: {', '.join(alone)}"
               if alone else ""),
        )  # fmt: skip
    return figure


_PASSAGE = " passes "
_BOX_ROOM, _PASSAGE_ROOM = 0.235, 0.09


def _is_passage(name: str) -> bool:
    return _PASSAGE in name


def _maker(name: str) -> str:
    """The rule that makes the files of a line."""
    return name.partition(_PASSAGE)[0]


def _box_width(rule: str) -> float:
    return 0.11 + 0.048 * len(_short(rule))


def _with_passages(columns, needs):
    """Columns including the passages of crossing lines, and links between adjacent columns."""
    layers = [list(rules) for rules in columns]
    column_of = {rule: number for number, rules in enumerate(columns) for rule in rules}
    links: dict[tuple[str, str, int], None] = {}
    for rule, near in needs.items():
        for one in sorted(near):
            if column_of[one] >= column_of[rule]:
                continue
            before = one
            for column in range(column_of[one] + 1, column_of[rule]):
                passage = f"{one}{_PASSAGE}{column}"
                if passage not in layers[column]:
                    layers[column].append(passage)
                links[before, passage, column - 1] = None
                before = passage
            links[before, rule, column_of[rule] - 1] = None
    return layers, list(links)


def _places(layers, links, sweeps: int = 12) -> list[dict[str, float]]:
    """Heights of boxes and passages: close to what they are linked to, without overlap."""
    near: dict[tuple[int, str], list[tuple[int, str]]] = {}
    for early, late, column in links:
        near.setdefault((column, early), []).append((column + 1, late))
        near.setdefault((column + 1, late), []).append((column, early))
    heights = [
        _apart({name: -0.01 * index for index, name in enumerate(layer)}) for layer in layers
    ]
    for sweep in range(sweeps):
        order = range(len(layers)) if sweep % 2 == 0 else range(len(layers) - 1, -1, -1)
        for column in order:
            side = -1 if sweep % 2 == 0 else 1
            wished = {}
            for name in layers[column]:
                linked = near.get((column, name), [])
                one_side = [heights[c][n] for c, n in linked if c == column + side]
                both = one_side or [heights[c][n] for c, n in linked]
                wished[name] = sum(both) / len(both) if both else heights[column][name]
            heights[column] = _apart(wished)
    return _without_gaps(heights)


def _without_gaps(heights: list[dict[str, float]]) -> list[dict[str, float]]:
    """The same heights with bands removed that are empty in all columns."""
    levels = sorted({y for layer in heights for y in layer.values()}, reverse=True)
    moved, lift = {}, 0.0
    for index, y in enumerate(levels):
        if index:
            lift += max(0.0, levels[index - 1] - y - _BOX_ROOM)
        moved[y] = y + lift
    return [{name: moved[y] for name, y in layer.items()} for layer in heights]


def _apart(wished: dict[str, float]) -> dict[str, float]:
    """Heights closest to the desired ones that keep their order and the necessary distances."""
    names = sorted(wished, key=lambda name: (-wished[name], name))
    rooms = [_PASSAGE_ROOM if _is_passage(name) else _BOX_ROOM for name in names]
    offsets, reach = [], 0.0
    for index, room in enumerate(rooms):
        reach += 0.5 * (room + rooms[index - 1]) if index else 0.0
        offsets.append(reach)
    # Isotonic least squares: adjacent blocks that overlap are merged (pool adjacent violators).
    blocks: list[list[float]] = []
    for name, offset in zip(names, offsets, strict=True):
        blocks.append([-(wished[name] + offset), 1.0])
        while len(blocks) > 1 and blocks[-2][0] > blocks[-1][0]:
            mean, count = blocks.pop()
            before, number = blocks[-1]
            blocks[-1] = [(before * number + mean * count) / (number + count), number + count]
    bases = [-mean for mean, count in blocks for _ in range(int(count))]
    return {n: base - offset for n, base, offset in zip(names, bases, offsets, strict=True)}


def _canvas(figure: Figure, share: tuple[float, float, float, float]):
    """Axes without a frame, in units of inches."""
    panel = figure.add_axes(share)
    width, height = figure.get_size_inches()
    panel.set_xlim(0.0, width * share[2])
    panel.set_ylim(0.0, height * share[3])
    panel.set_axis_off()
    return panel


def _way_to(target: str, needs: Mapping[str, set[str]]) -> dict[str, int]:
    """Rules that ``target`` depends on, with their level in the dependency graph."""

    def level(rule: str) -> int:
        return 1 + max((level(one) for one in needs[rule]), default=-1)

    found, waiting = {}, [target]
    while waiting:
        rule = waiting.pop()
        if rule not in found:
            found[rule] = level(rule)
            waiting += needs[rule]
    return found


def _columns(graph: pd.DataFrame, needs: Mapping[str, set[str]]) -> list[tuple[str, list[str]]]:
    """Title and rules of every column, by stage and within a stage by dependency."""
    stage_of = dict(zip(graph["rule"], graph["stage"], strict=True))
    title_of = {stage: title for title, stages in LANES for stage in stages}
    lanes: dict[str, list[str]] = {title: [] for title in (*dict(LANES), LAST_LANE)}
    for rule, stage in stage_of.items():
        drawn = rule.startswith("figure_")
        lanes[LAST_LANE if drawn else title_of.get(stage, LAST_LANE)].append(rule)

    def depth(rule: str, lane: list[str]) -> int:
        return 1 + max((depth(one, lane) for one in needs[rule] if one in lane), default=-1)

    columns = []
    for title, lane in lanes.items():
        levels: dict[int, list[str]] = {}
        for rule in lane:
            levels.setdefault(depth(rule, lane), []).append(rule)
        columns += [(title, levels[level]) for level in sorted(levels)]
    return columns


def _short(rule: str) -> str:
    return rule.removeprefix("figure_").replace("_", " ")


def _generation(panel, needs, chain, study) -> None:
    width, height = panel.get_xlim()[1], panel.get_ylim()[1]
    panel.text(0.08, height - 0.14, f"{style.letter(0)} generation of the data", va="center")
    levels = 2 + max(chain.values())
    step = (height - 0.75) / levels
    box = (min(1.62, 0.5 * width - 0.12), min(0.50, 0.68 * step))

    def y(level):
        return height - 0.36 - 0.5 * box[1] - (level + 1) * step

    x_middle = 0.5 * width
    top = height - 0.36 - 0.5 * box[1]
    source = study["external"]
    words = (
        ("configuration", f"ranges of 14 quantities, seed {study['seed']}, set-up")
        if source is None
        else ("external table", for_mathtext(Path(source).name))
    )
    _box(panel, x_middle, top, _WIDE, box[1], *words, tint="data")
    rows: dict[int, list[str]] = {}
    for rule, level in chain.items():
        rows.setdefault(level, []).append(rule)
    places = {}
    for level, rules in rows.items():
        for index, rule in enumerate(sorted(rules, key=lambda r: (r != "join_cases", r))):
            x = width * (index + 0.5) / len(rules) if len(rules) > 1 else x_middle
            places[rule] = (x, y(level))
    for rule, near in needs.items():
        for one in near:
            if rule in places and one in places:
                if chain[rule] - chain[one] == 1:
                    _down(panel, places[one], places[rule], box[1])
                else:
                    # Along the edge, past the boxes in between.
                    x, foot = 0.14, places[one][1] - 0.5 * box[1]
                    panel.plot([x, x], [foot, places[rule][1]], color=style.GREY, lw=0.9, zorder=1)
                    _arrow(panel, (x, places[rule][1]), (x_middle - 0.5 * _WIDE, places[rule][1]))
    numbers = {
        "sample": f"{study['cases']}, {_METHODS[study['method']]}; blocks: {study['blocks']}",
        "simulate": f"jobs: {study['jobs']}; wear for $W$ = 1",
    }
    for rule, (x, height_) in places.items():
        if not needs[rule]:
            _down(panel, (x_middle, top), (x, height_), box[1])
        title, leaves = WORDS.get(rule, (_short(rule), ""))
        wide = _WIDE if len(rows[chain[rule]]) == 1 else box[0]
        _box(panel, x, height_, wide, box[1], title, numbers.get(rule, leaves))
    end = y(levels - 2) - 0.5 * box[1]
    _arrow(panel, (x_middle, end), (x_middle, end - 0.3))
    panel.text(
        x_middle, end - 0.37, "learning, figures, tables, report", ha="center", va="center",
        fontsize=6.5, color=style.GREY,
    )  # fmt: skip


def _simulation(panel, setup: Setup) -> None:
    width, height = panel.get_xlim()[1], panel.get_ylim()[1]
    panel.text(0.08, height - 0.14, f"{style.letter(1)} set-up of each simulation", va="center")
    feed = (
        f"{setup.mass_rate:g} kg/s"
        if setup.mass_rate is not None
        else f"{setup.number_rate:g} particles/s"
    )
    mm = {name: f"{1e3 * getattr(setup, name):g}" for name in (
        "plate_length", "plate_width", "facet_size", "patch_length", "patch_width", "fall_height",
        "removal_depth",
    )}  # fmt: skip
    contact, pair = setup.contact, setup.pair_interaction
    pairs = (
        "pairs: as particle and plate"
        if pair is None
        else f"pairs: $e$ {pair.restitution:g}, $\\mu_s$ {pair.static_friction:g}, "
        f"$\\mu_r$ {pair.rolling_friction:g}"
    )
    step = (
        f"{setup.time_step_fraction:g} of the Rayleigh time"
        if setup.time_step is None
        else f"{setup.time_step:g} s"
    )
    x_middle, wide, half = 0.5 * width, 0.82 * width, 0.48 * width
    row = (height - 0.55) / 6.5
    tall = 0.68 * row

    def y(level):
        return height - 0.36 - 0.5 * tall - level * row

    left, right = 0.25 * width + 0.02, 0.75 * width - 0.02
    small = half - 0.1
    first = [
        (left, 0, "materials and interaction",
         "$G$, $\\nu$, $\\rho$ of particles and plate;\n$e$, $\\mu_s$, $\\mu_r$, $W$", "data"),
        (right, 0, "geometry and motion",
         "$\\varphi$, $\\theta$, $R$, $v_y$ of the case", "data"),
        (left, 1, "plate",
         f"{mm['plate_length']} × {mm['plate_width']} mm, facets {mm['facet_size']} mm", "step"),
        (right, 1, "factory",
         f"{mm['patch_length']} × {mm['patch_width']} mm, {mm['fall_height']} mm above;\n{feed}",
         "step"),
    ]  # fmt: skip
    for column in (left, right):
        _down(panel, (column, y(0)), (column, y(1)), tall)
        _down(panel, (column, y(1)), (x_middle, y(2)), tall)
    _down(panel, (x_middle, y(2)), (x_middle, y(3)), tall)
    _down(panel, (x_middle, y(3)), (x_middle, y(4)), tall)
    _down(panel, (x_middle, y(4)), (x_middle, y(5)), tall)
    for x, level, title, words, tint in first:
        _box(panel, x, y(level), small, tall, title, words, tint)
    _box(
        panel, x_middle, y(2), wide, tall, "contact law and time step",
        f"Hertz–Mindlin, {_plain(contact.normal)}, {_plain(contact.tangential)} tangential "
        f"spring;\n{pairs}; step {step}",
    )  # fmt: skip
    _box(
        panel, x_middle, y(3), wide, tall, "time integration",
        f"release, contact forces, motion, removal {mm['removal_depth']} mm below;\nadd "
        "$F_n\\,\\mathrm{d}s$ to the facet below each contact",
    )  # fmt: skip
    _box(
        panel, x_middle, y(4), wide, 1.1 * tall,
        f"steady for {setup.window:g} s, standard error at most "
        f"{100 * setup.target_stderr:g} %?",
        f"sampled every {setup.sample_interval:g} s; ends after {setup.max_time:g} s at the latest",
        "choice",
    )  # fmt: skip
    _box(
        panel, x_middle, y(5), wide, tall, "series, map, run",
        "worn volume over time, wear of each facet, final status", "data",
    )  # fmt: skip
    edge = x_middle + 0.5 * wide
    back = min(edge + 0.16, width - 0.12)
    panel.plot([edge, back, back, edge + 0.05], [y(4), y(4), y(3), y(3)], color=style.GREY, lw=0.9)
    panel.add_patch(
        Polygon([(edge, y(3)), (edge + 0.07, y(3) + 0.03), (edge + 0.07, y(3) - 0.03)],
                color=style.GREY, lw=0)
    )  # fmt: skip
    panel.text(back + 0.02, 0.5 * (y(3) + y(4)), "no", fontsize=6.5, color=style.GREY, va="center")
    panel.text(
        x_middle + 0.05, 0.5 * (y(4) + y(5)) - 0.02, "yes", fontsize=6.5, color=style.GREY,
        va="center",
    )  # fmt: skip


def _plain(name: str) -> str:
    return {"exact_e": "exact restitution $e$"}.get(name, name.replace("_", " "))


def _box(panel, x, y, width, height, title, words="", tint="step", edge=style.BLUE) -> None:
    panel.add_patch(
        FancyBboxPatch(
            (x - 0.5 * width, y - 0.5 * height), width, height, lw=0.8, edgecolor=edge,
            boxstyle="round,pad=0,rounding_size=0.04", facecolor=_TINT[tint], zorder=3,
        )
    )  # fmt: skip
    if not words:
        panel.text(x, y, title, ha="center", va="center", fontsize=6.5, zorder=4)
        return
    lines = 1 + words.count("\n")
    panel.text(
        x, y + 0.065 * lines, title, ha="center", va="center", fontsize=7.0, fontweight="bold",
        zorder=4,
    )  # fmt: skip
    panel.text(
        x, y - 0.075, words, ha="center", va="center", fontsize=6.5, zorder=4, linespacing=1.1,
    )  # fmt: skip


def _down(panel, start, end, height) -> None:
    """An arrow from the bottom of one box to the top of another."""
    _arrow(panel, (start[0], start[1] - 0.5 * height), (end[0], end[1] + 0.5 * height))


def _arrow(panel, start, end) -> None:
    panel.add_patch(
        FancyArrowPatch(
            start, end, lw=0.9, arrowstyle="-|>", mutation_scale=7, shrinkA=0, shrinkB=0,
            color=style.GREY, zorder=2,
        )
    )  # fmt: skip


def _curve(panel, start, end, colour) -> None:
    """A curved line between two points, horizontal at both ends."""
    bend = max(0.45 * (end[0] - start[0]), 0.05)
    panel.add_patch(
        FancyArrowPatch(
            path=Outline(
                [start, (start[0] + bend, start[1]), (end[0] - bend, end[1]), end],
                [Outline.MOVETO, Outline.CURVE4, Outline.CURVE4, Outline.CURVE4],
            ),
            arrowstyle="-", lw=0.8, color=colour, alpha=0.7, zorder=1, shrinkA=0, shrinkB=0,
        )
    )  # fmt: skip


def needs_of(graph: pd.DataFrame) -> dict[str, set[str]]:
    """Direct dependencies of each rule, without those that follow from the others."""
    direct = {rule: set(rows["needs"]) - {""} for rule, rows in graph.groupby("rule")}
    beyond: dict[str, set[str]] = {}

    def ancestors(rule: str) -> set[str]:
        if rule not in beyond:
            near = direct.get(rule, set())
            beyond[rule] = near.union(*(ancestors(one) for one in near))
        return beyond[rule]

    return {
        rule: {one for one in near if not any(one in ancestors(other) for other in near - {one})}
        for rule, near in direct.items()
    }
