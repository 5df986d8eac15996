"""Which cases a surrogate takes for unlike its training: planted influences and corners."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from flat_surrogate import write_flat_surrogate
from tables import drawn

from abradem.learning.model_files import write_model
from abradem.learning.physical.training_domain import MOST_CASES, domain_of, slopes_of, with_domain
from abradem.quantities import SAMPLED
from abradem.store.files import read_arrays, read_json
from abradem.surrogate.domain import HARMLESS, LEAST_SLOPE, Domain, warnings_on
from abradem.surrogate.groups import GROUP_NAMES, Jet, group_matrix
from abradem.surrogate.model import PredictionError, Surrogate

JET = Jet(0.385, 9.81, 42.0, None, 0.09, 0.09)

SLOPES = np.array([1.0, 0.5, 0.0])


def law(groups):
    """Logarithm of the wear number: two groups matter, the third does not."""
    return groups @ SLOPES


@pytest.fixture(scope="module")
def band():
    """Cases along the diagonal of the first two groups; no case is in the other corners."""
    rng = np.random.default_rng(0)
    along = rng.uniform(-1.5, 1.5, 300)
    return np.column_stack([along, along + rng.normal(0.0, 0.1, 300), rng.normal(size=300)])


@pytest.fixture(scope="module")
def domain(band):
    description, arrays = domain_of(law, band, np.arange(300), np.zeros(3), np.ones(3))
    return Domain(arrays["domain_rows"], arrays["domain_slopes"], description["limit"])


def test_slopes_are_those_of_the_law(band, domain):
    np.testing.assert_allclose(slopes_of(law, band, np.array([1.0, 2.0, 1.0])), [1.0, 1.0, 0.0],
                               atol=1e-9)  # fmt: skip
    np.testing.assert_allclose(domain.slopes, [1.0, 0.5, LEAST_SLOPE], rtol=1e-6)


def test_the_slope_of_a_curved_law_is_its_root_mean_square(band):
    found = slopes_of(lambda groups: groups[:, 0] ** 2, band, np.ones(3))
    assert found[0] == pytest.approx(2.0 * np.sqrt(np.mean(band[:, 0] ** 2)), rel=1e-9)


def test_distances_are_those_of_a_slow_twin(band, domain):
    points = np.random.default_rng(1).normal(size=(20, 3))
    expected = [
        np.mean(sorted(np.linalg.norm((point - row) * domain.slopes) for row in band)[:5])
        for point in points
    ]
    np.testing.assert_allclose(domain.distance(points), expected, rtol=1e-4)
    own = [
        np.mean(sorted(np.linalg.norm((band[i] - row) * domain.slopes) for row in band)[1:6])
        for i in range(len(band))
    ]
    assert domain.limit == pytest.approx(np.quantile(own, 0.99), rel=1e-3)


def test_new_cases_of_the_same_kind_are_rarely_far(domain):
    rng = np.random.default_rng(2)
    along = rng.uniform(-1.5, 1.5, 2000)
    fresh = np.column_stack([along, along + rng.normal(0.0, 0.1, 2000), rng.normal(size=2000)])
    assert np.mean(domain.distance(fresh) > domain.limit) < 0.03


def test_a_corner_that_nobody_sampled_is_far_though_inside_all_ranges(band, domain):
    corner = np.array([[1.4, -1.4, 0.0]])
    assert (corner > band.min(axis=0)).all() and (corner < band.max(axis=0)).all()
    assert domain.distance(corner)[0] > 2.0 * domain.limit


def test_a_group_without_influence_may_be_far_off_but_not_without_end(domain):
    assert domain.distance(np.array([[0.0, 0.0, 4.0]]))[0] < domain.limit
    assert domain.distance(np.array([[0.0, 0.0, 60.0]]))[0] > domain.limit


def test_repeated_cases_do_not_count_as_neighbours_and_many_are_thinned(band):
    _, once = domain_of(law, band, np.arange(300), np.zeros(3), np.ones(3))
    _, thrice = domain_of(law, np.repeat(band, 3, axis=0), np.repeat(np.arange(300), 3),
                          np.zeros(3), np.ones(3))  # fmt: skip
    np.testing.assert_array_equal(once["domain_rows"], thrice["domain_rows"])
    many = np.random.default_rng(3).normal(size=(2 * MOST_CASES, 3))
    _, thinned = domain_of(law, many, np.arange(len(many)), np.zeros(3), np.ones(3))
    assert len(thinned["domain_rows"]) == MOST_CASES


# Warnings

CASE = {row.name: np.array([float(np.mean(row.paper_range))]) for row in SAMPLED}
RANGES = {row.name: tuple(map(float, row.paper_range)) for row in SAMPLED}
NEAR = np.zeros(1, dtype=bool)


def numbers(columns):
    """The plate angle matters by 0.01 per degree, nothing else does; the deviation is 0.05."""
    mean = 0.01 * columns["plate_angle"]
    return mean, np.full(len(mean), np.log(0.05))


def asked(far=NEAR, **change):
    changed = {name: np.atleast_1d(np.asarray(value, float)) for name, value in change.items()}
    rows = len(next(iter(changed.values()))) if changed else 1
    columns = {name: np.broadcast_to(column, rows) for name, column in {**CASE, **changed}.items()}
    return warnings_on(columns, RANGES, numbers, far)


def test_a_quantity_without_influence_is_not_cried_over():
    assert asked() == asked(particle_shear_modulus=50e9) == []
    # 0.025 of the wear number are half a deviation, at 72.5 degrees.
    assert HARMLESS == 0.5
    assert asked(plate_angle=72.4) == []
    (line,) = asked(plate_angle=72.6)
    assert line.startswith("plate_angle = 72.6 deg is outside the training range 0 ... 70 deg")
    (line,) = asked(far=np.zeros(3, dtype=bool), plate_angle=[30.0, 85.0, 90.0])
    assert line.startswith("plate_angle = 85 deg in row 2 (and 1 more) is outside")


def test_a_far_case_is_one_line_with_what_is_outside():
    far = np.ones(1, dtype=bool)
    (line,) = asked(far)
    assert "this case is far from all training cases (each value is inside its range" in line
    (line,) = asked(far, particle_shear_modulus=50e9)
    assert "outside their ranges: particle_shear_modulus (2e+09 ... 1e+10 Pa)" in line
    # Where a quantity is named already, no second line says the same.
    (line,) = asked(far, plate_angle=90.0)
    assert line.startswith("plate_angle = 90 deg")
    (line,) = asked(np.array([False, True, True]), particle_density=[3000.0, 3000.0, 3000.0])
    assert line.startswith("row 2 (and 1 more) is far")


# In a surrogate


@pytest.fixture(scope="module")
def surrogate(tmp_path_factory):
    """A flat surrogate whose training cases were all slow on flat plates or fast on steep ones."""
    stem = tmp_path_factory.mktemp("flat") / "surrogate"
    write_flat_surrogate(stem, JET)
    table = drawn(200)
    table["particle_velocity_y"] = -1.0 - 9.0 * table["plate_angle"] / 70.0
    groups = group_matrix(table, JET)
    weights = np.zeros(len(GROUP_NAMES))
    weights[[GROUP_NAMES.index("log_froude"), GROUP_NAMES.index("plate_angle")]] = 0.5, 1.0
    process = SimpleNamespace(predict=lambda rows: rows @ weights)
    given = SimpleNamespace(groups=groups, table=SimpleNamespace(groups=np.arange(200)))
    model = read_json(f"{stem}.json"), read_arrays(f"{stem}.safetensors")
    write_model(*with_domain(model, process, given), f"{stem}.json")
    return Surrogate.load(stem)


def test_a_surrogate_warns_of_the_corner_and_of_it_alone(surrogate):
    case = {row.name: float(np.mean(row.paper_range)) for row in SAMPLED}
    for angle, speed in ((5.0, -1.6), (35.0, -5.5), (65.0, -9.4)):
        near = {**case, "plate_angle": angle, "particle_velocity_y": speed}
        assert surrogate.predict(near).warnings == []
    corner = {**case, "plate_angle": 65.0, "particle_velocity_y": -1.0}
    (line,) = surrogate.predict(corner).warnings
    assert line.startswith("this case is far from all training cases (each value is inside")
    several = {**case, "plate_angle": [5.0, 65.0], "particle_velocity_y": [-1.6, -1.0]}
    (line,) = surrogate.predict(several).warnings
    assert line.startswith("row 2 is far from all training cases")


@pytest.mark.parametrize(
    ("part", "words"),
    [
        ("domain_rows", "domain_rows is missing"),
        ("domain_slopes", "domain_slopes is missing"),
        ("limit", "domain.limit = None must be a finite number"),
    ],
)
def test_a_part_of_the_domain_that_is_missing_is_one_line(surrogate, tmp_path, part, words):
    description = dict(surrogate.description)
    model = surrogate.models["wear_friction_p99"]
    arrays = {
        "group_mean": surrogate.group_mean, "group_scale": surrogate.group_scale,
        "conformal": model.scores, "domain_rows": surrogate.domain.rows,
        "domain_slopes": surrogate.domain.slopes,
    }  # fmt: skip
    for name, layers in model.layers.items():
        for place, (weights, biases) in enumerate(layers):
            arrays |= {f"{name}_weights_{place}": weights, f"{name}_biases_{place}": biases}
    if part == "limit":
        description["domain"] = {}
    else:
        del arrays[part]
    write_model(description, arrays, tmp_path / "a.json")
    with pytest.raises(PredictionError, match=re.escape(words)):
        Surrogate.load(tmp_path / "a")
