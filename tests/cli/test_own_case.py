"""`abradem simulate` and `abradem sweep` for cases of one's own: input, output, one line each."""

import contextlib
import io
import re
from pathlib import Path

import matplotlib.image
import numpy as np
import pandas as pd
import pytest
from flat_surrogate import flat_prediction, write_flat_surrogate
from straight_engine import RATE, straight_line

import abradem
import abradem.dem
from abradem.cli.case_input import middle_of_ranges, patch_words, read_setup, surface_words
from abradem.cli.given_values import given_values, swept_values
from abradem.cli.main import _parser, main
from abradem.config import load_config, setup_dict
from abradem.config.materials import preset
from abradem.dataset.user_table import find_columns, read_user_table
from abradem.dem.model import Setup
from abradem.dem.surface import Feed, standing_surface
from abradem.quantities import SAMPLED, SAMPLED_NAMES, WEAR_COLUMNS, WEAR_MEASURES
from abradem.store.files import read_json, write_json
from abradem.store.tables import read_table, read_units
from abradem.surrogate.groups import jet_of
from abradem.surrogate.model import PredictionError

MIDDLE = {row.name: sum(row.paper_range) / 2 for row in SAMPLED}
DEFAULT = setup_dict(load_config({"study": "default"}))


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty working folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def asked(monkeypatch, here):
    """Cases and set-ups that the straight engine was asked for."""
    found = []

    def simulate(case, setup, **_):
        found.append((case, setup))
        return straight_line(case, setup)

    monkeypatch.setitem(vars(abradem.dem), "simulate", simulate)
    for command in ("simulate", "sweep_cases"):
        monkeypatch.setattr(f"abradem.cli.{command}.load_kernels", lambda setup, threads=1: None)
    return found


def run(capsys, *arguments):
    code = main([str(one) for one in arguments])
    out, err = capsys.readouterr()
    return code, out.splitlines(), err.splitlines()


def values_of(case):
    return {name: getattr(case, name) for name in SAMPLED_NAMES}


# Simulate: what is simulated


def test_a_case_needs_no_file_and_names_what_was_not_given(capsys, asked):
    code, _, err = run(capsys, "simulate", "plate_angle=45deg", "particle_radius=20mm")
    ((case, setup),) = asked
    assert code == 0 and setup == Setup.from_dict(DEFAULT)
    assert values_of(case) == pytest.approx(
        {**MIDDLE, "plate_angle": 45.0, "particle_radius": 0.02}, rel=1e-12
    )
    (line,) = err
    begin, _, named = line.partition(": ")
    assert begin == "not given, middle of the ranges of the default study"
    assert [one.split(" = ")[0] for one in named.split(", ")] == sorted(
        set(SAMPLED_NAMES) - {"plate_angle", "particle_radius"}
    )
    assert "particle_velocity_y = -5 m/s" in named


def test_a_preset_fills_before_the_ranges_and_the_command_line_before_both(capsys, asked):
    arguments = ["--material", "granite", "restitution=0.3", "--seed", "12"]
    _, _, err = run(capsys, "simulate", *arguments)
    ((case, _),) = asked
    expected = {**MIDDLE, **preset("granite"), "restitution": 0.3}
    assert values_of(case) == pytest.approx(expected) and case.seed == 12
    assert err[0].startswith("from the preset granite: ") and "restitution" not in err[0]
    assert err[1].startswith("not given, middle") and "density" not in err[1]


@pytest.mark.parametrize(
    ("text", "changed"),
    [
        ("factory.mass_rate_kg_s=10", {"mass_rate": 10.0}),
        ("simulation.factory.mass_rate_kg_s=36 t/h", {"mass_rate": 10.0}),
        ("mass_rate_kg_s=10", {"mass_rate": 10.0}),
        ("stop.window_s=1.5", {"window": 1.5}),
        ("plate.length_mm=60 cm", {"plate_length": 0.6}),
        ("contact.normal=nominal_clipped", {"contact": {**DEFAULT["contact"],
                                                        "normal": "nominal_clipped"}}),
        ("pair_interaction={restitution: 0.3, static_friction: 0.4, rolling_friction: 0.1}",
         {"pair_interaction": {"restitution": 0.3, "static_friction": 0.4,
                               "rolling_friction": 0.1}}),
    ],
)  # fmt: skip
def test_a_key_of_the_set_up_is_set_by_all_or_the_end_of_its_name(capsys, asked, text, changed):
    code, _, _ = run(capsys, "simulate", "--set", text)
    ((_, setup),) = asked
    assert code == 0 and setup == Setup.from_dict(DEFAULT | changed)


def test_the_configuration_here_is_taken_and_another_if_it_is_given(capsys, asked, here):
    Path("config.yaml").write_text(
        "study: mine\nseed: 9\nsampling: {ranges: {plate_angle: [10, 20]}}\n"
        "simulation: {stop: {window_s: 1.5}}\n"
    )
    Path("other.yaml").write_text("study: other\nsimulation: {stop: {window_s: 2}}\n")
    _, _, (line,) = run(capsys, "simulate")
    files = ["--config", "config.yaml", "--config", "other.yaml"]
    run(capsys, "simulate", *files, "--duration", "4 s")
    (mine, first), (_, second) = asked
    assert (mine.plate_angle, mine.seed, first.window) == (15.0, 9, 1.5)
    assert (second.window, second.duration, first.duration) == (2.0, 4.0, None)
    assert line.startswith("not given, middle of the ranges of config.yaml: ")


@pytest.mark.parametrize(
    "arguments",
    [
        ["plate_angle=20", "restitution=0.3", "--seed", "4"],
        ["--seed", "4", "plate_angle=20", "restitution=0.3"],
        ["plate_angle=20", "--seed", "4", "restitution=0.3"],
        ["plate_angle", "=", "20", "--seed", "4", "restitution=", "0.3"],
    ],
)
def test_values_and_options_may_be_in_any_order(capsys, asked, arguments):
    assert run(capsys, "simulate", *arguments)[0] == 0
    ((case, _),) = asked
    assert (case.plate_angle, case.restitution, case.seed) == (20.0, 0.3, 4)


def test_an_option_that_does_not_exist_is_named(capsys, asked):
    with pytest.raises(SystemExit):
        main(["simulate", "plate_angle=20", "--sead", "4", "restitution=0.3"])
    assert capsys.readouterr().err.startswith("abradem: unrecognized arguments: --sead")


# Simulate: what is said and written


def test_rates_have_errors_and_the_headline_is_that_of_the_study(capsys, asked):
    arguments = ["archard_constant=1e-9/Pa", "--set", "learning.target=wear_sliding_max"]
    _, (first, second, third), _ = run(capsys, "simulate", *arguments)
    mean = 1e3 * 1e-9 * RATE / 0.09
    assert first == "ok, 3.5 s simulated"
    # Elements of 30 mm are rows of three of the thirty facets of a ramp.
    assert second.startswith(f"wear depth rate {mean * 29 / 15.5:.6g} mm/s, standard error ")
    assert "(sliding, worst " in second and "element)" in second
    assert third.startswith(f"mean over the plate {mean:.4g} (standard error ")
    assert third.count("(standard error ") == 4


@pytest.mark.parametrize("suffix", [".parquet", ".csv"])
def test_the_map_is_a_table_with_units_whose_mean_is_the_rate(capsys, asked, suffix):
    path = Path(f"out/map{suffix}")
    assert run(capsys, "simulate", "archard_constant=1e-9/Pa", "--map", path)[0] == 0
    if suffix == ".csv":
        table = pd.read_csv(path)
        units = dict(re.fullmatch(r"(\w+)(?: \[(.*)\])?", name).groups() for name in table)
        table.columns = list(units)
    else:
        table, units = read_table(path), read_units(path)
    assert units["x"] == units["z"] == "mm" and units["depth_rate_friction"] == "mm/s"
    assert len(table) == 900
    for axis in "xz":
        expected = np.arange(-145.0, 146.0, 10.0)
        np.testing.assert_allclose(np.unique(table[axis].round(9)), expected, rtol=1e-12)
    for measure in WEAR_MEASURES:
        rates = table[f"depth_rate_{measure}"]
        assert rates.mean() == pytest.approx(1e3 * 1e-9 * RATE / 0.09)
        assert rates.max() / rates.min() == pytest.approx(30.0)
        assert table["x"][rates.idxmax()] == pytest.approx(145.0)


@pytest.mark.parametrize("name", ["map.png", "series.PNG", "map.pdf", "series.svg"])
def test_pictures_are_written_by_their_suffix(capsys, asked, name):
    option = "--map" if name.startswith("map") else "--series"
    assert run(capsys, "simulate", option, name)[0] == 0
    (path,) = Path().iterdir()
    assert path.name == name.replace("PNG", "png")
    content = path.read_bytes()
    assert content.startswith({"n": b"\x89PNG", "f": b"%PDF", "g": b"<?xml"}[path.name[-2]
                              if path.suffix == ".png" else path.name[-1]])  # fmt: skip
    if path.suffix == ".png":
        assert matplotlib.image.imread(path).std() > 0.05


def test_the_series_has_the_schema_of_a_study(capsys, asked):
    run(capsys, "simulate", "--series", "series.parquet", "--map", "m.csv")
    series = read_table("series.parquet")
    np.testing.assert_array_equal(series["worn_friction"], RATE * series["time"])
    assert read_units("series.parquet")["worn_friction"] == "J"


def test_without_a_steady_window_no_rate_and_no_map_are_written(capsys, asked, monkeypatch):
    monkeypatch.setitem(
        vars(abradem.dem), "simulate",
        lambda case, setup, **_: straight_line(case, setup, steady=False),
    )  # fmt: skip
    code, out, err = run(capsys, "simulate", "--map", "map.png", "--series", "series.csv")
    assert code == 1 and out == ["ok, 3.5 s simulated"]
    assert err[-2:] == [
        "--map map.png: not written, no complete window",
        f"no wear rate: the plate did not wear steadily for the window of {DEFAULT['window']:g} s; "
        "simulate longer, or shorten simulation.stop.window_s",
    ]
    assert [path.name for path in Path().iterdir()] == ["series.csv"]


# Simulate: beside the surrogate


def test_the_surrogate_of_the_study_is_asked_if_it_is_there(capsys, asked, here):
    jet = jet_of(DEFAULT)
    stem = here / "results/default/models/surrogate"
    write_flat_surrogate(stem, jet)
    _, out, err = run(capsys, "simulate", "plate_angle=20")
    rate, low, high = flat_prediction({**MIDDLE, "plate_angle": 20.0}, jet)
    assert out[-1].startswith(
        f"surrogate results/default/models/surrogate: {rate:.4g} mm/s, 95 % interval {low:.4g} to "
        f"{high:.4g} mm/s (wear_friction_p99: "
    )
    assert f"; simulated {float(out[1].split()[3]):.4g} mm/s, standard error " in out[-1]
    assert not [line for line in err if line.startswith("warning")]


@pytest.mark.parametrize(
    ("theirs", "given", "warned"),
    [
        ({"restitution": 0.5, "static_friction": 0.5, "rolling_friction": 0.01}, [], False),
        (None, [], True),
        (None, ["--set", "pair_interaction=null"], False),
        ({"restitution": 0.5, "static_friction": 0.5, "rolling_friction": 0.01},
         ["--set", "pair_interaction.restitution=0.4"], True),
        ("not said", [], False),
    ],
)  # fmt: skip
def test_a_surrogate_of_other_contacts_between_particles_warns(
    capsys, asked, here, theirs, given, warned
):
    write_flat_surrogate(here / "s", jet_of(DEFAULT))
    if theirs != "not said":
        description = read_json(here / "s.json")
        write_json({**description, "pair_interaction": theirs}, here / "s.json")
    _, _, err = run(capsys, "simulate", "--model", here / "s", *given)
    assert any("other contacts between particles" in line for line in err) == warned


def test_a_surrogate_of_another_jet_or_range_warns(capsys, asked, here):
    write_flat_surrogate(here / "s", jet_of(DEFAULT))
    description = read_json(here / "s.json")
    ranges = {feature["name"]: feature for feature in description["features"]}
    ranges["plate_angle"]["training_range"] = [45.0, 45.0]
    write_json(description, here / "s.json")
    changed = ["--set", "factory.mass_rate_kg_s=10", "plate_angle=80"]
    _, out, err = run(capsys, "simulate", "--model", here / "s", *changed)
    assert out[-1].startswith(f"surrogate {here / 's'}: ")
    assert (
        "warning: the surrogate was trained with another set-up: mass_rate 43.0 instead of 10.0"
        in (err)
    )
    assert any("plate_angle = 80 deg: this quantity was held fixed" in line for line in err)


# Simulate: what is refused


def test_all_that_is_wrong_is_told_at_once_and_nothing_is_simulated(capsys, asked):
    Path("folder.png").mkdir()
    arguments = [
        "particle_radius=20m", "particle_velocity_y=5", "plate_angel=4", "--duration=-1s",
        "--set", "factory.mass_rate_kg_s=-1", "--set", "factory.mas_rate=3", "--set", "x",
        "--map", "x.txt", "--series", "folder.png", "--seed", "-1", "--interval", "2",
        "--material", "granit",
    ]  # fmt: skip
    code, out, err = run(capsys, "simulate", *arguments)
    assert code == 2 and out == [] and asked == []
    text = "\n".join(err)
    for words in (
        "particle_radius = 20 m is impossible (allowed 0.0001 ... 0.1 m)",
        "particle_velocity_y = 5 m/s is impossible (allowed -30 ... 0 m/s; down is negative)",
        "plate_angel (did you mean plate_angle?): no such quantity",
        "--duration -1s: must be positive",
        "--set x: is not of the form KEY=VALUE",
        "--map x.txt: must end with one of .parquet, .csv, .png, .pdf, .svg, .vtp",
        "--series folder.png: is a folder; name a file",
        "--seed -1: is outside 0 ... 9223372036854775807",
        "--interval needs --snapshots FOLDER",
        "--material granit: no such preset, did you mean granite?",
        "command line: simulation.factory.mass_rate_kg_s: -1: is out of range",
        "command line: simulation.factory.mas_rate: 3: unknown key",
    ):
        assert text.count(words) == 1, words
    assert len(err) == 12
    assert [path.name for path in Path().iterdir()] == ["folder.png"]


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--case", "3"], "--case needs --study FOLDER"),
        (["--study", "x"], "--study needs --case N"),
        (["--study", "x", "--case", "3", "plate_angle=3", "--seed", "1"],
         "--study repeats a case as it is, without --seed, NAME=VALUE"),
        (["particle_radius=90mm", "--set", "plate.width_mm=150"],
         "this case cannot be simulated: particle of radius 0.09 m is wider than the plate "
         "(0.15 m)"),
        (["--model", "none"],
         "none.json: there is no such file; run the study first (make run), or give the surrogate "
         "of another study"),
        (["--set", "mass_rate_kg_s=1, angle_acts: level"],
         "command line: simulation: "),
        (["--set", "target=1"],
         "--set target=1: may mean learning.target or calibration.target; "),
        (["--config", "none.yaml"], "none.yaml: there is no such file"),
        (["--set", "mass_rate_kg_s=1", "--map", "x.vtp"],
         "--map x.vtp: the plate is shown by snakemake vtk (allowed with a geometry)"),
        (["--set", "geometry.kind=arc", "factory_angle=-30deg"],
         "factory_angle: means nothing with geometry.kind: arc (allowed without it)"),
    ],
)  # fmt: skip
def test_one_line_says_what_is_wrong(capsys, asked, arguments, line):
    code, out, err = run(capsys, "simulate", *arguments)
    assert code == 2 and out == [] and asked == []
    assert len(err) == 1 and err[0].startswith(line)


def test_a_scene_is_for_a_geometry_from_whichever_option_it_comes(capsys, asked):
    Path("arc.yaml").write_text("study: arc\nsimulation: {geometry: {kind: arc}}\n", "utf-8")
    for geometry in (["--config", "arc.yaml"], ["--set", "geometry.kind=arc"]):
        code, _, err = run(capsys, "simulate", *geometry, "--map", "x.vtp", "--seed", "-1")
        assert code == 2 and len(err) == 1 and err[0].startswith("--seed -1")
    assert asked == []


def test_a_geometry_with_ranges_is_in_their_middle(capsys, asked):
    Path("g.yaml").write_text(
        "study: g\nsimulation: {geometry: {kind: arc, arc: {radius_mm: [400, 600], end: 20}}}\n",
        "utf-8",
    )
    problems = []
    options = _parser().parse_args(["simulate", "--config", "g.yaml"])
    own = read_setup(options, problems)
    shape = own.setup["geometry"]["shape"]
    assert problems == [] and shape["radius"] == "arc_radius" and shape["end"] == 20.0
    assert middle_of_ranges(own, [])["arc_radius"] == 0.5
    assert "arc_radius" not in middle_of_ranges(own, ["arc_radius"])


PLATE_OF_ITS_OWN = """\
study: g
simulation: {plate: {length_mm: 600, width_mm: 240}, factory: {mass_rate_kg_s: 3}}
sampling: {ranges: {factory_angle: [-20, 0], plate_angle: [10, 30], restitution: 0.4}}
"""
CHAIN = """\
study: g
simulation:
  geometry: {kind: plates, plates: [{length_mm: 300, width_mm: 300, angle: 30, name: one}]}
learning: {part: one}
"""


@pytest.mark.parametrize("text", [PLATE_OF_ITS_OWN, CHAIN])
def test_a_mesh_replaces_the_plate_or_the_geometry_of_the_configuration(here, text):
    """And what the files say of that; what is on the command line counts."""
    Path("g.yaml").write_text(text, "utf-8")
    asked = ["simulate", "--config", "g.yaml", "--geometry", "mine.stl", "--unit", "in"]
    problems = []
    own = read_setup(_parser().parse_args(asked), problems)
    assert problems == [] and own.setup["geometry"]["shape"]["kind"] == "mesh"
    assert own.config.learning.part is None
    if text == PLATE_OF_ITS_OWN:
        assert own.setup["mass_rate"] == 3.0
        assert middle_of_ranges(own, [])["restitution"] == 0.4
    more = [*asked, "--set", "plate.length_mm=600"]
    assert read_setup(_parser().parse_args(more), problems) is None
    assert (
        "plate.length_mm: 600: means nothing beside simulation.geometry.kind: mesh" in problems[0]
    )


def test_a_check_of_a_configuration_reads_its_mesh(capsys, here):
    Path("g.yaml").write_text(
        "study: g\nsimulation: {geometry: {kind: mesh, mesh: {file: none.stl}}}\n", "utf-8"
    )
    code, out, err = run(capsys, "config", "--check", "g.yaml")
    assert (code, out) == (2, []) and err == [
        "no case can be simulated: none.stl: there is no such file (allowed: a mesh file)"
    ]


# The kernels


@pytest.mark.parametrize("geometry", [None, {"kind": "arc"}])
@pytest.mark.parametrize("compiled", [True, False])
def test_a_compilation_is_said_before_and_after(monkeypatch, capsys, compiled, geometry):
    from abradem.cli.case_input import load_kernels
    from abradem.dem import cache, warm

    loaded = []
    monkeypatch.setattr(cache, "is_compiled", lambda *needed: compiled)
    monkeypatch.setattr(warm, "load", lambda *needed: loaded.append(needed))
    load_kernels({"stepping": "islands", "geometry": geometry})
    lines = capsys.readouterr().err.splitlines()
    assert loaded == [("islands", geometry is not None)]
    assert len(lines) == (0 if compiled else 2)
    if not compiled:
        assert lines[0].startswith("compiling the engine, once") and lines[1] == "compiled in 0 s"


@pytest.mark.parametrize(
    ("geometry", "threads", "needed"),
    [
        (None, 1, [("islands", False)]),
        (None, 2, [("islands", False), ("parallel", False)]),
        ({"kind": "arc"}, 2, [("islands", True)]),
    ],
)
def test_threads_need_kernels_of_their_own_on_the_plate_alone(
    monkeypatch, geometry, threads, needed
):
    from abradem.cli.case_input import load_kernels
    from abradem.dem import cache, warm

    loaded = []
    monkeypatch.setattr(cache, "is_compiled", lambda *needed: True)
    monkeypatch.setattr(warm, "load", lambda *needed: loaded.append(needed))
    load_kernels({"stepping": "islands", "geometry": geometry}, threads)
    assert loaded == needed


def test_a_stepping_is_compiled_when_its_kernel_is_in_the_cache(monkeypatch, tmp_path):
    from abradem.dem import cache

    monkeypatch.setattr(cache, "cache_folder", lambda: tmp_path)
    (tmp_path / "dem_0").mkdir()
    (tmp_path / "dem_0" / "islands.advance-80.py311.nbi").write_bytes(b"")
    assert cache.is_compiled("islands") and not cache.is_compiled("synchronous")


def test_the_real_kernels_are_found_in_the_cache_once_they_are_loaded():
    from abradem.dem import cache, warm

    for on_surface in (False, True):
        warm.load("islands", on_surface)
        assert cache.is_compiled("islands", on_surface)


def test_the_kernels_of_the_plate_are_not_those_of_a_surface(monkeypatch, tmp_path):
    from abradem.dem import cache

    monkeypatch.setattr(cache, "cache_folder", lambda: tmp_path)
    (tmp_path / "islands.advance-80.py311.nbi").write_bytes(b"abradem.dem.state")
    assert cache.is_compiled("islands") and not cache.is_compiled("islands", on_surface=True)
    (tmp_path / "islands.advance-80.py311.nbi").write_bytes(b"abradem.dem.state abradem.dem.mesh")
    assert cache.is_compiled("islands", on_surface=True)


def test_processes_compile_one_after_the_other(monkeypatch, tmp_path):
    """While one compiles, another waits: it cannot have the lock before the first is done."""
    import subprocess
    import sys

    from abradem.dem import cache

    monkeypatch.setattr(cache, "cache_folder", lambda: tmp_path)
    code = (
        "import sys, pathlib; from abradem.dem import cache; "
        "cache.cache_folder = lambda: pathlib.Path(sys.argv[1])\n"
        "print('asks', flush=True)\n"
        "with cache.compiling(): print('has', flush=True)"
    )
    with cache.compiling():
        other = subprocess.Popen(
            [sys.executable, "-c", code, str(tmp_path)], stdout=subprocess.PIPE, text=True
        )
        assert other.stdout.readline() == "asks\n"
        with pytest.raises(subprocess.TimeoutExpired):
            other.wait(0.5)
    assert other.communicate(timeout=60)[0] == "has\n"


# Threads


@pytest.mark.parametrize(
    ("options", "threads"),
    [((), 1), (("--threads", "3"), 3), (("--set", "simulation.threads=2"), 2)],
)
def test_threads_are_those_asked_for_or_of_the_configuration(
    monkeypatch, capsys, asked, options, threads
):
    given, loaded = [], []

    def simulate(case, setup, threads=1):
        given.append(threads)
        return straight_line(case, setup)

    monkeypatch.setitem(vars(abradem.dem), "simulate", simulate)
    monkeypatch.setattr(
        "abradem.cli.simulate.load_kernels", lambda setup, threads: loaded.append(threads)
    )
    assert run(capsys, "simulate", *options)[0] == 0
    assert given == [threads]
    assert loaded == [threads]


@pytest.mark.parametrize("text", ["0", "65", "1.5", "many"])
def test_a_number_of_threads_that_is_impossible_is_refused(capsys, asked, text):
    with pytest.raises(SystemExit):
        main(["simulate", "--threads", text])
    assert f"'{text}' is not a number of threads (allowed 1 ... 64)" in capsys.readouterr().err


# Lists and ranges


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("plate_angle=0:70:35", (0.0, 35.0, 70.0)),
        ("plate_angle=0:70:30", (0.0, 30.0, 60.0)),
        ("plate_angle=0:1:0.1", tuple(round(0.1 * place, 12) for place in range(11))),
        ("plate_angle=70:0:-35", (70.0, 35.0, 0.0)),
        ("plate_angle=5:5:1", (5.0,)),
        ("particle_radius=10mm,2cm", (0.01, 0.02)),
        ("particle_radius=10,20mm", (0.01, 0.02)),
        ("particle_radius=10:30:10 mm", (0.01, 0.02, 0.03)),
        ("particle_radius=10mm:3cm:10mm", (0.01, 0.02, 0.03)),
        ("particle_velocity_y=-2,-4 m/s", (-2.0, -4.0)),
        ("archard_constant=1e-9,1e-8/Pa", (1e-9, 1e-8)),
        ("particle_radius_mm=10,20", (0.01, 0.02)),
    ],
)
def test_lists_and_ranges_are_read_in_the_unit_of_their_last_number(text, values):
    found = swept_values([text], None)
    assert found.fixed.values == {}
    (name,) = found.lists
    assert found.lists[name] == pytest.approx(values, rel=1e-12, abs=1e-12)


def test_the_last_value_of_a_range_is_exactly_the_one_that_is_given():
    assert swept_values(["plate_angle=0:0.3:0.1"], None).lists["plate_angle"][-1] == 0.3


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("plate_angle=0:70", "is not a range FIRST:LAST:STEP or a list A,B,C"),
        ("plate_angle=0:70:5:1", "is not a range FIRST:LAST:STEP or a list A,B,C"),
        ("plate_angle=0,10:70:5", "is not a range FIRST:LAST:STEP or a list A,B,C"),
        ("plate_angle=0:70:0", "the step does not lead from the first to the last"),
        ("plate_angle=0:70:-5", "the step does not lead from the first to the last"),
        ("plate_angle=0:70:0.001", "has more than 10000 values"),
        ("plate_angle=0,,5", "has an empty place"),
        ("plate_angle=0,5,0", "holds a value twice"),
        ("particle_radius=10,20deg", "unit 'deg' has another dimension"),
        ("plate_angle=0:200:50", "plate_angle = 100 deg is impossible (allowed -90 ... 90 deg)"),
    ],
)
def test_a_list_that_cannot_be_meant_is_refused(capsys, here, text, words):
    code, out, err = run(capsys, "sweep", text)
    assert code == 2 and out == [] and words in err[0]


def test_predict_and_simulate_take_no_lists():
    with pytest.raises(PredictionError, match="plate_angle"):
        given_values(["plate_angle=0,10"], None)


# Sweep


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_sweep_is_a_table_with_units_that_predict_can_read(capsys, asked, suffix):
    path = Path(f"out/sweep{suffix}")
    code, out, _ = run(
        capsys, "sweep", "plate_angle=0:60:30", "particle_radius=20,30mm", "restitution=0.4",
        "--seed", 5, "--output", path, "--cores", 1,
    )  # fmt: skip
    assert code == 0 and out == [f"6 cases simulated, written to {path}"]
    assert [(case.plate_angle, case.particle_radius) for case, _ in asked] == [
        (angle, radius) for angle in (0.0, 30.0, 60.0) for radius in (0.02, 0.03)
    ]
    assert {case.restitution for case, _ in asked} == {0.4} and {c.seed for c, _ in asked} == {5}
    table = read_user_table(path)
    places, faulty = find_columns(table, SAMPLED_NAMES)
    assert set(places) == set(SAMPLED_NAMES) and not faulty and len(table.frame) == 6
    if suffix == ".parquet":
        units = read_units(path)
        assert {units[name] for name in WEAR_COLUMNS} == {"mm/s"} and units["plate_angle"] == "deg"


def test_a_sweep_is_printed_if_no_file_is_given_and_a_case_without_a_rate_is_named(
    capsys, asked, monkeypatch
):
    monkeypatch.setitem(
        vars(abradem.dem), "simulate",
        lambda case, setup, **_: straight_line(case, setup, steady=case.plate_angle > 0.0),
    )  # fmt: skip
    code, out, err = run(capsys, "sweep", "plate_angle=0,30", "--cores", 1)
    assert code == 1 and len(out) == 3
    assert out[0].startswith("plate_angle [deg],particle_shear_modulus [Pa],")
    assert err[-2:] == [
        "2 cases simulated, 1 without a wear rate",
        "no wear rate: plate_angle = 0: stderr+unsteady",
    ]


@pytest.mark.parametrize(
    ("target", "words"),
    [
        ("wear_friction_p99", "Wear depth rate, friction, 99th percentile of 30 mm elements"),
        ("wear_total_mean", "Wear depth rate, total, mean over the plate"),
    ],
)
def test_the_picture_of_a_sweep_shows_the_headline_of_the_study(
    capsys, asked, monkeypatch, target, words
):
    import abradem.cli.sweep_cases as command

    drawn = []
    monkeypatch.setattr(command, "_draw", lambda *given: drawn.append(given))
    code, out, _ = run(
        capsys, "sweep", "plate_angle=0,30", "particle_radius=20,30mm", "--cores", 1,
        "--set", f"learning.target={target}", "--figure", "s.png", "--output", "s.csv",
    )  # fmt: skip
    assert code == 0 and out == ["4 cases simulated, written to s.csv and s.png"]
    ((table, swept, rate, low, high, said, bars, path),) = drawn
    assert (rate, said, bars, path) == (target, words, "bars: standard error", Path("s.png"))
    assert list(swept.lists) == ["plate_angle", "particle_radius"]
    np.testing.assert_allclose((low + high) / 2, table[target])
    np.testing.assert_allclose((high - low) / 2, table[f"{target}_stderr"], atol=1e-18)


def test_an_interrupted_sweep_goes_on_and_writes_the_same_bytes(capsys, asked, monkeypatch):
    sweep = ("sweep", "particle_radius=20:40:5mm", "--cores", 1, "--output")
    assert run(capsys, *sweep, "whole.csv")[0] == 0
    whole = abradem.dem.simulate
    count = len(asked)

    def until_the_third(case, setup, **options):
        if len(asked) == count + 3:
            raise KeyboardInterrupt
        return whole(case, setup, **options)

    with monkeypatch.context() as patch:
        patch.setitem(vars(abradem.dem), "simulate", until_the_third)
        with contextlib.suppress(KeyboardInterrupt):
            main([str(one) for one in (*sweep, "part.csv")])
    assert sorted(path.name for path in Path().iterdir()) == ["part.csv.finished", "whole.csv"]
    assert run(capsys, *sweep, "part.csv")[0] == 0
    assert len(asked) == count + 5
    assert Path("part.csv").read_bytes() == Path("whole.csv").read_bytes()
    assert not Path("part.csv.finished").exists()


def test_the_picture_of_a_simulated_sweep_is_written(capsys, asked):
    run(capsys, "sweep", "particle_radius=20:40:5mm", "--cores", 1, "--figure", "s.png")
    assert [path.name for path in Path().iterdir()] == ["s.png"]
    assert matplotlib.image.imread("s.png").std() > 0.05


def test_a_sweep_of_the_surrogate_simulates_nothing(capsys, asked, here):
    jet = jet_of(DEFAULT)
    write_flat_surrogate(here / "s", jet)
    code, out, _ = run(
        capsys, "sweep", "plate_angle=0:70:10", "particle_radius=10,20mm", "--surrogate",
        "--model", here / "s", "--output", "s.parquet", "--figure", "s.png", "--confidence", "90",
    )  # fmt: skip
    assert code == 0 and asked == []
    assert out == ["16 cases predicted, written to s.parquet and s.png"]
    table = read_table("s.parquet")
    rate, _, high = flat_prediction(table, jet)
    np.testing.assert_allclose(table["wear_depth_rate"], rate, rtol=1e-6)
    np.testing.assert_allclose(table["wear_depth_rate_upper"], high, rtol=1e-6)
    assert read_units("s.parquet")["wear_depth_rate"] == "mm/s"
    assert matplotlib.image.imread("s.png").std() > 0.05


def test_all_that_is_wrong_with_a_sweep_is_told_at_once(capsys, asked):
    code, out, err = run(
        capsys, "sweep", "plate_angle=0,95", "restitutions=0.1,0.2", "--output", "x.txt",
        "--figure", "x.csv", "--cores", 0, "--confidence", "x", "--model", "m", "--set", "y=1",
    )  # fmt: skip
    assert code == 2 and out == [] and asked == [] and list(Path().iterdir()) == []
    text = "\n".join(err)
    for words in (
        "restitutions (did you mean restitution?): no such quantity",
        "plate_angle = 95 deg is impossible",
        "--output x.txt: must end with one of .csv, .parquet",
        "--figure x.csv: must end with one of .png, .pdf, .svg",
        "--cores 0: must be at least 1",
        "--confidence x: is not a number",
        "--model needs --surrogate",
        "--confidence needs --surrogate",
        "command line: simulation.y: 1: unknown key",
    ):
        assert text.count(words) == 1, words


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["plate_angle=3", "--figure", "x.png"],
         "--figure needs a quantity with several values"),
        (["plate_angle=0:70:1", "restitution=0.2:0.8:0.01", "--figure", "x.png"],
         "--figure: 61 curves are too many to tell apart (allowed 14)"),
        (["plate_angle=0:70:1", "restitution=0.2:0.8:0.001"],
         "the sweep has 42671 cases (allowed 20000)"),
        (["plate_angle=0,3", "--surrogate", "--seed", "1"],
         "--seed is for simulations, without --surrogate"),
        (["plate_angle=0,3", "--set", "geometry.kind=arc"],
         "plate_angle: means nothing with geometry.kind: arc (allowed without it)"),
        (["restitution=0.3,0.5", "--geometry", "none.stl", "--output", "s.csv"],
         "no case can be simulated: none.stl: there is no such file"),
        (["plate_angle=0,3", "--surrogate"],
         "results/default/models/surrogate.json: there is no such file"),
    ],
)  # fmt: skip
def test_one_line_says_what_is_wrong_with_a_sweep(capsys, asked, arguments, line):
    code, out, err = run(capsys, "sweep", *arguments)
    assert code == 2 and out == [] and asked == []
    assert len(err) == 1 and err[0].startswith(line)


# Progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize(
    ("setup", "end"),
    [({"duration": 5.0}, "of 5 s"), ({"max_time": 10.0, "duration": None}, "s, at most 10 s")],
)
def test_progress_is_a_line_that_is_cleared_and_only_on_a_terminal(monkeypatch, setup, end):
    from abradem.cli.case_input import progress_line

    monkeypatch.setattr("sys.stderr", io.StringIO())
    assert progress_line(setup)[0] is None
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    progress, clear = progress_line(setup)
    progress(1.5)
    # At most five times a second.
    progress(1.6)
    assert terminal.getvalue() == f"\r\x1b[2Ksimulated 1.50 {end}"
    clear()
    assert terminal.getvalue().endswith("\r\x1b[2K")


def test_a_case_of_ones_own_shows_its_progress_on_a_terminal(monkeypatch, asked):
    def simulate(case, setup, progress=None):
        progress(0.25)
        return straight_line(case, setup)

    monkeypatch.setitem(vars(abradem.dem), "simulate", simulate)
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    assert main(["simulate"]) == 0
    lines = terminal.getvalue().split("\r\x1b[2K")
    assert lines[1] == f"simulated 0.25 s, at most {DEFAULT['max_time']:g} s" and lines[2] == ""


def test_a_sweep_counts_its_cases_on_a_terminal(monkeypatch, asked):
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    assert main(["sweep", "plate_angle=0,20,40", "--cores", "1", "--output", "s.csv"]) == 0
    shown = terminal.getvalue().split("\r\x1b[2K")[1:]
    assert shown == ["1 of 3 cases simulated", "2 of 3 cases simulated", ""]


def test_the_place_of_the_factory_is_told_in_millimetres():
    feed = Feed((0.1, 0.5, 0.0), (0.2, 0.0, 0.0), (0.0, 0.0, 0.4), (0.0, -1.0, 0.0))
    assert patch_words(feed) == "factory of 200 x 400 mm, centre at x = 100, y = 500, z = 0 mm"


def test_the_surface_is_told_with_its_extent():
    surface = standing_surface([[0, 0, 0], [0.4, 0, 0], [0, 0.3, 0.2], [0, 0, 0.2]],
                               [[0, 1, 2], [0, 1, 3]])  # fmt: skip
    assert surface_words(surface) == (
        "surface of 400 x 300 x 200 mm along x, y and z, 2 cells in 1 part"
    )
