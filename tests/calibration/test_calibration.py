"""Calibration: planted set-ups come back, scores are those of their formulas, rows are fair."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats
from tables import drawn

from abradem.calibration.agreement import SCORES, agreement, scored
from abradem.calibration.halving import best_readings, rungs, survivors
from abradem.calibration.outcome import equally_good, outcome, profiles
from abradem.calibration.rows import arranged_rows
from abradem.calibration.space import draw, keys_of, unknowns
from abradem.calibration.trials import run_trial
from abradem.config import Config, read_config, setup_dict
from abradem.dataset.power_fit import wear_exponents

RATE, ACTS = "simulation.factory.mass_rate_kg_s", "simulation.factory.angle_acts"
SIDES = "simulation.factory.patch_length_mm, simulation.factory.patch_width_mm"
SPACE = {
    RATE: {"from": 2.0, "to": 40.0, "scale": "log"},
    ACTS: ["tilt", "level"],
    SIDES: [100, 200],
}


ROOT = Path(__file__).parents[2]


def dilute():
    """The configuration of the dilute study, in which small tables cost little."""
    return read_config(ROOT / "config.yaml", ROOT / "studies/dilute.yaml")


# Search space


def test_set_ups_fill_the_space_evenly_and_are_the_same_for_a_seed():
    space = unknowns(SPACE)
    trials = draw(space, 64, seed=1)
    assert trials == draw(space, 64, seed=1) != draw(space, 64, seed=2)
    # The first set-ups stay when there are more.
    assert draw(space, 128, seed=1)[:64] == trials
    rates = np.log([one[RATE] for one in trials])
    counts, _ = np.histogram(rates, bins=np.linspace(np.log(2.0), np.log(40.0), 9))
    assert counts.min() >= 6 and counts.max() <= 10
    assert [sum(one[ACTS] == value for one in trials) for value in ("tilt", "level")] == [32, 32]
    assert all(one[RATE] == float(f"{one[RATE]:.3g}") for one in trials)


def test_keys_that_share_a_value_get_it():
    assert keys_of({SIDES: 200, ACTS: "tilt"}) == {
        "simulation.factory.patch_length_mm": 200,
        "simulation.factory.patch_width_mm": 200,
        ACTS: "tilt",
    }


@pytest.mark.parametrize(
    ("search", "words"),
    [
        ({"seed": [1, 2]}, "seed: is no key of a simulation"),
        ({RATE: [4]}, "needs at least two plain values"),
        ({RATE: [4, 4]}, "holds a value twice"),
        ({RATE: [4, 4.0]}, "holds a value twice"),
        ({RATE: [300.0, 300.00000000000006]}, "holds a value twice"),
        ({RATE: 4}, "must be a list of values or"),
        ({RATE: {"from": 4}}, "must be a list of values or"),
        ({RATE: {"from": 4, "to": 4}}, "must be below"),
        ({RATE: {"from": 0, "to": 4, "scale": "log"}}, "must be positive on a logarithmic scale"),
        ({RATE: {"from": 1, "to": 4, "scale": "cubic"}}, "scale = 'cubic' is unknown"),
        ({RATE: {"from": "a", "to": 4}}, "'a' is not a number"),
        ({RATE: [1, 2], f"{RATE}, {ACTS}": [1, 2]}, "is given twice"),
    ],
)
def test_a_space_that_is_none_is_one_line(search, words):
    with pytest.raises(ValueError, match=words) as error:
        unknowns(search)
    assert len(str(error.value).splitlines()) == 1


# Rows


def test_rows_held_out_and_every_first_part_cover_the_range_of_the_wear():
    table = drawn(99).assign(wear_total_mean=np.random.default_rng(1).lognormal(size=99))
    rows = arranged_rows(table, "wear_total_mean", every=4, least_radius=0.0)
    held = rows[rows["part"] == "held out"]
    assert len(held) == 25 and set(rows["part"]) == {"used", "held out"}
    ranks = table["wear_total_mean"].rank().set_axis(table["case_id"])
    assert np.diff(sorted(ranks[held["case_id"]])).max() == 4
    used = rows.loc[rows["part"] == "used", "case_id"]
    for count in (5, 10, 20, 40):
        gaps = np.diff([0.0, *sorted(ranks[used[:count]]), 100.0])
        assert gaps.max() < 3.0 * 100.0 / count
    assert rows["case_id"].is_unique and len(rows) == 99


def test_small_particles_are_left_out_and_nothing_is_held_out_if_not_asked():
    table = drawn(40).assign(wear_total_mean=1.0 + np.arange(40.0))
    rows = arranged_rows(table, "wear_total_mean", every=0, least_radius=0.02)
    small = rows["particle_radius"] < 0.02
    assert (rows.loc[small, "part"] == "left out").all()
    assert (rows.loc[~small, "part"] == "used").all() and small.any()


# Scores


def test_the_scores_are_those_of_their_formulas():
    rng = np.random.default_rng(0)
    given = rng.lognormal(size=50)
    simulated = given * np.exp(0.3 + 0.1 * rng.standard_normal(50))
    found = agreement(given, simulated)
    log_y, log_p = np.log(given), np.log(simulated)
    assert found["constant"] == pytest.approx(np.exp(np.mean(log_y - log_p)))
    assert found["spearman"] == pytest.approx(stats.spearmanr(given, simulated)[0])
    for name, y, p in (
        ("log_r2", log_y, log_p),
        ("log_r2_constant", log_y, log_p + np.log(found["constant"])),
        ("r2", given, simulated),
        ("r2_constant", given, found["constant"] * simulated),
    ):
        assert found[name] == pytest.approx(1.0 - np.mean((y - p) ** 2) / np.var(y))
    assert found["log_r2_constant"] > found["log_r2"]
    perfect = agreement(given, given)
    assert perfect == pytest.approx(dict.fromkeys(SCORES, 1.0))


@pytest.mark.parametrize(
    ("given", "simulated"),
    [
        ([1.0, 2.0, 3.0], [1.0, 2.0, 3.0]),
        ([1.0, 2.0, 3.0, 4.0], [1.0, 2.0, 0.0, 4.0]),
        ([1.0, 2.0, 3.0, 4.0], [1.0, 2.0, np.nan, 4.0]),
        ([2.0, 2.0, 2.0, 2.0], [1.0, 2.0, 3.0, 4.0]),
    ],
)
def test_what_has_no_score_has_none(given, simulated):
    assert all(np.isnan(value) for value in agreement(given, simulated).values())


def test_the_noise_of_a_score_is_its_scatter_over_replicates():
    """The jackknife against the scatter of the score over many draws of the replicates."""
    rng = np.random.default_rng(3)
    given = pd.Series(rng.lognormal(size=60), index=range(60))

    def score_of(seed):
        noisy = given.to_numpy()[:, None] * np.exp(
            0.2 * np.random.default_rng(seed).standard_normal((60, 6))
        )
        runs = pd.DataFrame(
            {
                "trial": 0,
                "case_id": np.repeat(np.arange(60), 6),
                "replicate": np.tile(np.arange(6), 60),
                "element_size": 0.03,
                **{f"wear_{m}_{s}": noisy.ravel() for m in ("total", "sliding", "friction")
                   for s in ("mean", "worn", "footprint", "p99", "max")},
            }
        )  # fmt: skip
        return scored(runs, given).iloc[0]

    found = [score_of(seed) for seed in range(40)]
    spread = np.std([one["log_r2"] for one in found], ddof=1)
    stated = np.mean([one["log_r2_noise"] for one in found])
    assert 0.6 < stated / spread < 1.6


def test_exponents_of_a_planted_law_come_back():
    rows = drawn(80, seed=4)
    setup = setup_dict(dilute())
    speed = rows["particle_velocity_y"] ** 2 + 2.0 * 9.81 * 0.25
    wear = (
        3.0 * rows["archard_constant"] * rows["particle_radius"] ** 0.87
        * rows["particle_density"] ** 0.24 * speed * rows["static_friction"] ** -0.77
        * (1.0 + rows["restitution"]) ** -0.37 * np.exp(0.5 * rows["plate_angle"] / 70.0)
    )  # fmt: skip
    found = wear_exponents(rows, wear.to_numpy(), setup).set_index("quantity")["exponent"]
    expected = {
        "archard_constant": 1.0, "particle_radius": 0.87, "particle_density": 0.24,
        "impact_speed": 1.0, "static_friction": -0.77, "restitution": -0.37, "plate_angle": 0.5,
        "factory_angle": 0.0,
    }  # fmt: skip
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, abs=1e-9)
    fixed = wear_exponents(rows.assign(static_friction=0.5), wear.to_numpy(), setup)
    assert "static_friction" not in set(fixed["quantity"])


# Halving


def test_each_rung_keeps_a_share_and_the_best():
    found = rungs(64, 0.25, [16, 40, 99], [1, 2, 4])
    assert [rung.trials for rung in found] == [64, 16, 4]
    assert found[1] == (16, 40, 2)
    scores = pd.DataFrame(
        {
            "trial": [0, 0, 1, 2, 3],
            "measure": "total",
            "statistic": ["max", "mean", "mean", "mean", "mean"],
            "element_size": [0.03, np.nan, np.nan, np.nan, np.nan],
            "rows": 9,
            "missing": [0, 0, 0, 0, 3],
            "log_r2": [0.5, 0.7, 0.9, np.nan, 0.99],
        }
    )
    assert survivors(scores, "log_r2", 3) == [1, 0]
    assert best_readings(scores, "log_r2")["statistic"].tolist() == ["mean", "mean"]
    with pytest.raises(ValueError, match="no set-up of the search has a log_r2 on all 9 rows"):
        survivors(scores.assign(missing=1), "log_r2", 3)


# A planted set-up


@pytest.fixture(scope="module")
def planted():
    """A table made by the engine itself under a set-up that the search does not know."""
    truth = {RATE: 15.0, ACTS: "level", SIDES: 200}
    space = unknowns({RATE: {"from": 3.0, "to": 48.0, "scale": "log"}, ACTS: SPACE[ACTS],
                      SIDES: SPACE[SIDES]})  # fmt: skip
    rows = drawn(18, seed=5)
    rows["particle_radius"] = np.linspace(0.02, 0.035, 18)
    rows["particle_velocity_y"] = np.linspace(-6.0, -3.0, 18)[np.argsort(rows["restitution"])]

    def setup_of(values):
        config = dilute().model_dump()
        for key, value in keys_of(values).items():
            *path, name = key.split(".")
            section = config
            for part in path:
                section = section[part]
            section[name] = float(value) if not isinstance(value, str) else value
        made = setup_dict(Config.model_validate(config))
        return {**made, "window": 3.0, "max_time": 8.0, "target_stderr": 0.1}

    table = run_trial(0, rows.assign(block=0, seed=900 + rows["case_id"]), setup_of(truth), 4,
                      [0.03])  # fmt: skip
    given = table.groupby("case_id")["wear_friction_max"].mean()
    rows["wear_total_mean"] = given.loc[rows["case_id"]].to_numpy()
    arranged = arranged_rows(rows, "wear_total_mean", every=3, least_radius=0.0)
    trials = [*draw(space, 16, seed=2), truth]
    setups = [setup_of(values) for values in trials]
    part = arranged[arranged["part"] != "left out"]
    runs = pd.concat(
        [run_trial(at, part, setup, 2, [0.03, 0.05]) for at, setup in enumerate(setups)],
        ignore_index=True,
    )
    return truth, space, arranged, trials, setups, runs


def of_trials(runs, numbers):
    return runs[runs["trial"].isin(numbers)]


def test_a_planted_set_up_is_found_among_others(planted):
    truth, space, rows, trials, setups, runs = planted
    summary, predicted, slopes = outcome(rows, runs, trials, setups, space, "log_r2")
    # The seeds of the rows differ from those of the planted table, so others may be as good.
    assert 16 in summary["equal_trials"] and len(summary["equal_trials"]) < 6
    for name in (ACTS, SIDES, RATE):
        assert truth[name] in summary["equal"][name]
    assert summary["scores"]["used"]["log_r2"] > 0.95
    assert summary["scores"]["held out"]["log_r2"] > 0.9
    assert 0.85 < summary["scores"]["both"]["constant"] < 1.15
    planted_one = runs[(runs["trial"] == 16) & (runs["element_size"] == 0.03)]
    simulated = planted_one.groupby("case_id")["wear_friction_max"].mean()
    given = rows.set_index("case_id")["given"].loc[simulated.index]
    assert agreement(given, simulated)["log_r2"] > 0.95
    mean, spread = summary["scores"]["used"]["single"]["log_r2"]
    assert mean < summary["scores"]["used"]["log_r2"] and spread > 0.0
    assert set(predicted["part"]) == {"used", "held out"}
    assert slopes["quantity"].is_unique and len(slopes) >= 6
    assert (slopes["ratio_exponent"].abs() < 4.0 * slopes["ratio_stderr"]).all()


def test_a_planted_set_up_that_was_not_drawn_lies_within_the_stated_uncertainty(planted):
    truth, space, rows, trials, _, runs = planted
    drawn_ones = of_trials(runs, range(16))
    scores = scored(drawn_ones, rows.set_index("case_id")["given"])
    found = profiles(scores, trials, space, "log_r2").set_index(["unknown", "value"])
    for name, value in ((ACTS, "level"), (SIDES, "200"), ("measure", "friction"),
                        ("statistic", "max"), ("element_size", "30 mm")):  # fmt: skip
        assert not found.loc[(name, value), "told_apart"], (name, value)
    rate = found.loc[RATE].reset_index()
    possible = rate[~rate["told_apart"]]
    assert possible["low"].min() <= truth[RATE] <= possible["high"].max()
    assert rate["told_apart"].any()
    assert len(equally_good(scores, "log_r2")) < 16
