"""The schema of all tables: meaning, unit and type of each column.

`abradem.store.tables.write_table` only accepts columns with a `Column` entry, so every number is
stored with its unit.
"""

from __future__ import annotations

from dataclasses import dataclass

from abradem.quantities import (
    GEOMETRY_UNITS,
    QUANTITIES,
    STATISTICS,
    TARGET,
    WEAR_MEASURES,
    stderr_column,
    wear_column,
)
from abradem.words.labels import LABELS, MEASURE_WORDS, STATISTIC_WORDS


@dataclass(frozen=True)
class Column:
    """Metadata of a column.

    Parameters
    ----------
    unit : str
        Unit; "1" for dimensionless numbers and text.
    long_name : str
        Short description.
    dtype : {"float64", "float32", "int64", "int32", "bool", "string"}
    """

    unit: str
    long_name: str
    dtype: str = "float64"


KEYS = {
    "case_id": Column("1", "number of the case in the study", "int64"),
    "block": Column("1", "block of the sample the case belongs to", "int32"),
    "seed": Column("1", "seed of the released positions", "int64"),
}


CASES = {"rejected": Column("1", "why the case is physically inconsistent, or empty", "string")}


SERIES = {
    "time": Column("s", "simulated time"),
    "worn_total": Column("J", "cumulative normal force times distance of all tangential motion"),
    "worn_sliding": Column("J", "cumulative normal force times sliding distance"),
    "worn_friction": Column("J", "cumulative friction work over the coefficient of friction"),
    "delivered_mass": Column("kg", "cumulative mass released"),
    "particles_present": Column("1", "particles present", "int32"),
}


MAPS = {
    "facet_x": Column("1", "facet index along the plate's length", "int32"),
    "facet_z": Column("1", "facet index along the plate's width", "int32"),
    **{
        f"wear_{measure}": Column(
            "J", f"normal force times distance in the window ({MEASURE_WORDS[measure]})"
        )
        for measure in WEAR_MEASURES
    },
}


GEOMETRY = {
    name: Column(unit, f"{name.replace('_', ' ')} of the geometry")
    for name, unit in GEOMETRY_UNITS.items()
}


CELLS = {
    "part_name": Column("1", "part of the surface", "string"),
    "cell_area": Column("m2", "area of the cell"),
    "impacts": Column("1", "impacts in the window"),
    "impact_speed": Column("m/s", "mean speed of the impacts"),
    "impact_angle": Column("deg", "mean angle of the impacts from the normal"),
    "normal_work": Column("J", "work of the normal force in the window, absolute in each step"),
    "tangential_work": Column(
        "J", "work of the tangential force in the window, absolute in each step"
    ),
    "normal_impulse": Column("N s", "impulse of the normal force in the window"),
}
"""Columns of the maps of a surface, whose cells are counted by facet_x."""


PARTS = {
    "window_part": Column("1", "part of the window, in order of time, from 0", "int32"),
    **{
        f"part_wear_{measure}": Column(
            "J",
            f"normal force times distance in the part of the window ({MEASURE_WORDS[measure]})",
            "float32",
        )
        for measure in WEAR_MEASURES
    },
}


RUNS = {
    "settled": Column("1", "whether wear rate and particles present had stopped to drift", "bool"),
    "status": Column("1", "ok, or why the case ended early", "string"),
    "simulated_time": Column("s", "simulated time at the end"),
    "steady_from": Column("s", "end of the transient"),
    "window_start": Column("s", "start of the window over which facets are compared"),
    "window_end": Column("s", "end of the window over which facets are compared"),
    "window_parts": Column("1", "equal parts of the window, 0 if there is none", "int32"),
    "stderr": Column("1", "relative standard error of the mean wear rate at the stop"),
    "time_step": Column("s", "time step"),
    "requested_rate": Column("kg/s", "feed asked for"),
    "delivered_rate": Column("kg/s", "feed achieved"),
    "face_share": Column("1", "share of first contacts on the plate's face"),
    "edge_share": Column("1", "share of first contacts on an edge or corner"),
    "missed_share": Column("1", "share of particles that left without a contact"),
    "max_overlap": Column("1", "largest overlap as a share of the radius"),
    "released": Column("1", "particles released", "int64"),
    "removed": Column("1", "particles removed", "int64"),
}


TIMES = {"processor_time": Column("s", "processor time that the case took")}


WEAR_RATES = {
    **{
        wear_column(measure, statistic): Column(
            "mm/s",
            f"wear depth rate, {STATISTIC_WORDS[statistic]} ({MEASURE_WORDS[measure]})",
        )
        for measure in WEAR_MEASURES
        for statistic in STATISTICS
    },
    **{
        stderr_column(wear_column(measure, statistic)): Column(
            "mm/s",
            f"standard error of the wear depth rate, {STATISTIC_WORDS[statistic]} "
            f"({MEASURE_WORDS[measure]})",
        )
        for measure in WEAR_MEASURES
        for statistic in STATISTICS
    },
    "wear_r2": Column("1", "R2 of the cumulative wear against a straight line (description)"),
    "wear_batches": Column("1", "batches of increments behind the standard error", "int32"),
    "wear_lag1": Column("1", "lag-1 correlation of the batches"),
    "worn_volume_rate": Column("m3/s", "worn volume of the whole plate per time"),
    "wear_per_kg": Column("m3/kg", "worn volume per mass delivered"),
    "quality": Column("1", "ok, or the flags of the case joined by +", "string"),
}


LEARNING = {
    "model": Column("1", "model", "string"),
    "protocol": Column("1", "protocol of training and evaluation", "string"),
    "table": Column("1", "table learned from", "string"),
    "split": Column("1", "kind of rows evaluated", "string"),
    "repeat": Column("1", "number of the random split, -1 for all rows", "int32"),
    "metric": Column("1", "metric", "string"),
    "value": Column("1", "value of the metric, in the unit that the column unit names"),
    "unit": Column("1", "unit of the value", "string"),
    "symbol": Column("1", "symbol of the feature", "string"),
    "feature": Column("1", "feature", "string"),
    "coefficient": Column("1", "coefficient between standardised feature and target"),
    "standard_error": Column("1", "standard error of the coefficient"),
    "lower": Column("1", "lower end of the interval"),
    "upper": Column("1", "upper end of the interval"),
    "identified": Column("1", "whether the rows determine this coefficient", "bool"),
    "actual": Column(TARGET.unit, "simulated wear depth rate"),
    "predicted": Column(TARGET.unit, "predicted wear depth rate"),
    "floor": Column(TARGET.unit, "smallest wear depth rate of the training rows"),
    "scale": Column(TARGET.unit, "scale of the wear, W m' v^2 / (2 A)"),
    "variation": Column("1", "varied, held fixed or not identified in these rows", "string"),
    "variance_inflation": Column("1", "variance inflation factor"),
    "fitted": Column("1", "fitted target, in its standard deviations"),
    "residual": Column("1", "residual, in standard deviations of the target"),
    "leverage": Column("1", "leverage of the row"),
    "studentised": Column("1", "residual over its own standard error"),
    "normal_quantile": Column("1", "quantile of the normal distribution at the residual's rank"),
    "printed": Column("1", "coefficient as printed"),
    "refitted": Column("1", "coefficient by the same steps"),
    "verdict": Column("1", "whether print and refit agree", "string"),
    "weight": Column("1", "weight between standardised feature and target"),
    "survives": Column("1", "share of the fits in which the feature stays"),
    "alpha": Column("1", "penalty"),
    "mean": Column("1", "mean R2 over the folds"),
    "stderr_of_mean": Column("1", "standard error of that mean"),
    "chosen": Column("1", "whether this one was chosen", "bool"),
    "component": Column("1", "principal component", "int32"),
    "components": Column("1", "number of principal components", "int32"),
    "loading": Column("1", "loading of the feature on the component"),
    "correlation": Column("1", "Pearson correlation"),
    "other": Column("1", "the other quantity", "string"),
    "variance": Column("1", "variance along the component, of scaled features"),
    "share": Column("1", "share of the variance"),
    "cumulative": Column("1", "share of the variance up to this component"),
    "explained": Column("1", "what the regression explains", "string"),
    "r2": Column("1", "R2"),
    "r2_lower": Column("1", "lower end of the interval of R2"),
    "r2_upper": Column("1", "upper end of the interval of R2"),
    "lasso_weight": Column("1", "standardised weight of the lasso"),
    "ridge_weight": Column("1", "standardised weight of the ridge regression"),
    "leading_share": Column("1", "share in the leading principal components"),
    "chosen_by": Column("1", "weight, loading, or empty if not chosen", "string"),
    "in_paper": Column("1", "whether the study chose the feature", "bool"),
    "depth": Column("1", "largest depth of the tree", "int32"),
    "node": Column("1", "number of the node", "int32"),
    "parent": Column("1", "node above, -1 at the root", "int32"),
    "left": Column("1", "node where feature <= threshold, -1 at a leaf", "int32"),
    "right": Column("1", "node where feature > threshold, -1 at a leaf", "int32"),
    "threshold": Column("1", "threshold, in the unit that the column unit names"),
    "rows": Column("1", "rows in the node", "int64"),
    "importance": Column("1", "share of the variance removed by splits on the feature"),
    "generation": Column("1", "generation of the search", "int32"),
    "individual": Column("1", "number in the generation", "int32"),
    "layers": Column("1", "neurons of the hidden layers", "string"),
    "parameters": Column("1", "weights and biases", "int64"),
    "weights_seed": Column("1", "seed of the start weights", "int64"),
    "parent_a": Column("1", "first parent in the generation before, -1 for none", "int32"),
    "parent_b": Column("1", "second parent in the generation before, -1 for none", "int32"),
    "origin": Column("1", "how the individual came about", "string"),
    "fitness": Column("1", "R2 on the rows that the protocol names"),
    "basis": Column("1", "what the score and its interval rest on", "string"),
    "repeats": Column("1", "number of scores behind it", "int32"),
    "printed_r2": Column("1", "R2 as printed"),
    "as_published_r2": Column("1", "R2 by the steps as published"),
    "leakage_free_r2_log": Column("1", "R2 of ln y by the leakage-free protocol"),
    "leakage_free_r2_number": Column(
        "1", "R2 of the logarithm of the wear number by the leakage-free protocol"
    ),
    "leakage_free_r2": Column("1", "R2 by the leakage-free protocol"),
    "leakage_free_lower": Column("1", "lower end of the interval of the leakage-free R2"),
    "leakage_free_upper": Column("1", "upper end of the interval of the leakage-free R2"),
    "remark": Column("1", "what to know about the printed figure", "string"),
}


MODELS = {
    "target": Column("1", "column of the data set that is explained", "string"),
    "raised": Column("1", "targets that were not positive and were raised", "int32"),
    "r2_log": Column("1", "R2 of the logarithm"),
    "r2_number": Column("1", "R2 of the logarithm of the wear number"),
    "rmse": Column(TARGET.unit, "root mean square error"),
    "mae": Column(TARGET.unit, "mean absolute error"),
    **{
        f"{name}_{end}": Column(unit, f"{end} end of the interval of the {words}")
        for name, unit, words in (
            ("r2_log", "1", "R2 of the logarithm"),
            ("r2_number", "1", "R2 of the logarithm of the wear number"),
            ("rmse", TARGET.unit, "root mean square error"),
            ("mae", TARGET.unit, "mean absolute error"),
            ("mape", "1", "mean absolute relative error"),
        )
        for end in ("lower", "upper")
    },
    "term": Column("1", "term of the power law", "string"),
    "kind": Column("1", "whether the term is a quantity or a dimensionless group", "string"),
    "words": Column("1", "what it is, in words", "string"),
    "exponent": Column("1", "exponent, or coefficient in the exponential"),
    "method": Column("1", "how the interval is made", "string"),
    "level": Column("1", "nominal level of the interval"),
    "coverage": Column("1", "share of held-out rows inside the interval"),
    "band_lower": Column("1", "lower end of the binomial band of the coverage"),
    "band_upper": Column("1", "upper end of the binomial band of the coverage"),
    "joint_lower": Column("1", "lower end of the band that holds all coverages of a test at once"),
    "joint_upper": Column("1", "upper end of the band that holds all coverages of a test at once"),
    "in_joint": Column("1", "whether the coverage is in its joint band", "bool"),
    "width": Column("1", "median of upper end over prediction, less 1"),
    "tested": Column("1", "rows held out", "int64"),
    "fold": Column("1", "fold in which the row was held out", "int32"),
    "log_deviation": Column("1", "standard deviation of ln y that the process predicts"),
    "error_scale": Column("1", "factor of that deviation, learned from other held-out rows"),
    "score": Column("1", "held-out error of ln y by deviation and scale"),
    "region": Column("1", "part of the ranges of the study", "string"),
    "case_share": Column("1", "share of the test rows that are in the region"),
    "error_share": Column("1", "share of the sum of squared errors of the wear"),
    "number_error_share": Column(
        "1", "share of the sum of squared errors of the logarithm of the wear number"
    ),
    "in_band": Column("1", "whether the coverage is in its binomial band", "bool"),
    "trained": Column("1", "rows trained on", "int64"),
    "test": Column("1", "test of extrapolation", "string"),
    "mape": Column("1", "mean absolute relative error"),
    "within_r2": Column("1", "R2 on the same rows of models that saw such rows"),
    "within_mape": Column("1", "mean absolute relative error of models that saw such rows"),
    "first": Column("1", "first-order Sobol index"),
    "first_lower": Column("1", "lower end of the interval of the first-order index"),
    "first_upper": Column("1", "upper end of the interval of the first-order index"),
    "total": Column("1", "total Sobol index"),
    "total_lower": Column("1", "lower end of the interval of the total index"),
    "total_upper": Column("1", "upper end of the interval of the total index"),
    "fall": Column("1", "fall of R2 when the quantity is shuffled among held-out rows"),
    "fall_lower": Column("1", "least fall of the splits"),
    "fall_upper": Column("1", "largest fall of the splits"),
    "setting": Column("1", "value the quantity is set to, in its own unit"),
    "replicate": Column("1", "number of the repetition with another seed", "int32"),
    "replicates": Column("1", "simulations of the same case", "int32"),
    "relative_spread": Column("1", "standard deviation over seeds by the mean"),
    "relative_stderr": Column("1", "standard error that the simulations state, by the mean"),
}


COLUMNS: dict[str, Column] = {
    **KEYS,
    **{q.name: Column(q.unit, LABELS[q.name].long_name) for q in QUANTITIES},
    **GEOMETRY,
    **CASES,
    **SERIES,
    **MAPS,
    **CELLS,
    **PARTS,
    **RUNS,
    **TIMES,
    **WEAR_RATES,
    **LEARNING,
    **MODELS,
}
"""Columns of the tables of a study; a name has the same meaning in all of them."""


# Columns of individual tables; they override columns of the same name in `COLUMNS`.

SNAPSHOTS = {
    "particle": Column("1", "number of the particle, in the order of release", "int64"),
    "partner": Column("1", "number of the other particle, -1 for the plate", "int64"),
    **{name: Column("m", f"position of the centre along {name}") for name in "xyz"},
    **{f"v{axis}": Column("m/s", f"velocity along {axis}") for axis in "xyz"},
    **{f"w{axis}": Column("rad/s", f"spin about {axis}") for axis in "xyz"},
    "normal_force": Column("N", "normal force, elastic and damping"),
    **{
        f"tangential_force_{axis}": Column("N", f"tangential force on the particle along {axis}")
        for axis in "xyz"
    },
    **{
        f"wear_{measure}": Column("J", f"cumulative F_n ds of the facet ({measure}), W = 1")
        for measure in WEAR_MEASURES
    },
}
"""Tables of `abradem.simulation.snapshots`."""


CELL_TABLE = {
    "cell": Column("1", "number of the cell in the surface", "int64"),
    **{axis: Column("m", f"centre of the cell along {axis}") for axis in "xyz"},
    **{f"normal_{axis}": Column("1", f"unit normal of the cell along {axis}") for axis in "xyz"},
    **{
        f"depth_rate_{measure}": Column(
            "mm/s", f"wear depth rate of the cell in the window ({MEASURE_WORDS[measure]})"
        )
        for measure in WEAR_MEASURES
    },
    "area": Column("m2", "area of the part"),
}
"""Tables of `abradem.wear.surface_cells`."""


PART_EFFECTS = {
    "quantity": Column("1", "quantity that varied", "string"),
    "unit": Column("1", "unit of the quantity", "string"),
    "cases": Column("1", "cases with a rate", "int64"),
    "rank_correlation": Column("1", "rank correlation of the quantity and the wear rate"),
    **{
        name: Column("1", f"{words}, in the unit of the column unit")
        for name, words in (
            ("low_from", "smallest value"), ("low_to", "largest value of the lower third"),
            ("high_from", "smallest value of the upper third"), ("high_to", "largest value"),
        )
    },
    "low_rate": Column("mm/s", "mean wear depth rate in the lower third of the values"),
    "high_rate": Column("mm/s", "mean wear depth rate in the upper third of the values"),
}  # fmt: skip
"""Table of `abradem.wear.part_effects`."""


MAP_RATES = {
    "x": Column("mm", "centre of the facet along the slope, from the centre of the plate"),
    "z": Column("mm", "centre of the facet across the slope, from the centre of the plate"),
    **{
        f"depth_rate_{measure}": Column(
            "mm/s", f"wear depth rate of the facet in the window ({MEASURE_WORDS[measure]})"
        )
        for measure in WEAR_MEASURES
    },
}
"""Map of a case of one's own, `abradem.cli.case_files`."""


PREDICTED_MAP = {
    "x": Column("mm", "centre of the element along the slope, from the centre of the plate"),
    "z": Column("mm", "centre of the element across the slope, from the centre of the plate"),
    "depth_rate": Column("mm/s", "wear depth rate of the element that the map surrogate predicts"),
}
"""Map of `abradem predict --map`, `abradem.cli.predict_map`."""


PREDICTED = {
    "wear_depth_rate": Column("mm/s", "wear depth rate that the surrogate predicts"),
    "wear_depth_rate_lower": Column("mm/s", "lower end of its interval"),
    "wear_depth_rate_upper": Column("mm/s", "upper end of its interval"),
}
"""Predictions of a sweep, `abradem.cases.sweep`."""


ANGLES = {
    "varied": Column("1", "quantity that is varied", "string"),
    "angle": Column("deg", "value of the quantity that is varied"),
    "wear_depth": Column("mm", "mean wear depth of the plate"),
    "rate": Column("mm/s", "steady wear depth rate, mean over the plate"),
    "rate_stderr": Column("mm/s", "its standard error"),
}
"""Tables of wear by angle, `abradem.wear.angles`."""


RULE_GRAPH = {
    "rule": Column("1", "rule of the workflow", "string"),
    "stage": Column("1", "file of rules it stands in", "string"),
    "needs": Column("1", "rule whose files it takes, empty for none", "string"),
}
"""Table of `abradem.running.rule_graph`."""


def _columns(unit: str, dtype: str = "float64", /, **names: str) -> dict[str, Column]:
    return {name: Column(unit, words, dtype) for name, words in names.items()}


EXPONENTS = {
    **_columns("1", "string", quantity="quantity", verdict="whether both exponents agree"),
    **_columns("1", "int64", rows="cases used"),
    **_columns(
        "1",
        exponent="exponent in the wear rate of the study",
        exponent_stderr="its standard error",
        published_exponent="exponent in the published data",
        published_stderr="its standard error",
        combined_errors="difference by the root of the sum of both squared standard errors",
    ),
}
"""Table of `abradem.learning.exponents`."""


CALIBRATION = {
    **_columns(
        "1",
        "int64",
        trial="number of the set-up",
        rows="rows scored",
        rung="last rung",
        missing="simulations without a wear rate",
        trials="set-ups with this value",
    ),
    **_columns(
        "1",
        "string",
        values="values of the unknowns",
        measure="wear measure",
        statistic="statistic over the elements",
        unknown="unknown",
        value="value",
        part="used, held out or left out",
        quantity="quantity",
        status="ok, or why the simulation gave no result",
    ),
    **_columns("1", "int32", replicate="number of the replicate"),
    **_columns("1", "bool", told_apart="whether the score differs from that of the best value"),
    **_columns("m", element_size="edge of the elements"),
    **_columns(
        "mm/s",
        given="wear depth rate in the table",
        simulated="simulated wear depth rate",
        simulated_stderr="standard error over the replicates",
    ),
    **_columns(
        "1",
        low="lower bound of the part of a range",
        high="its upper bound",
        score="best score with this value",
        noise="standard error of the score",
        **{
            name: words
            for score, meaning in (
                ("log_r2", "R2 of ln y without a constant"),
                ("log_r2_constant", "R2 of ln y with a constant"),
                ("r2", "R2 of y without a constant"),
                ("r2_constant", "R2 of y with a constant"),
                ("spearman", "rank correlation"),
                ("constant", "constant that fits the simulated rates"),
            )
            for name, words in (
                (score, meaning),
                (f"{score}_noise", f"standard error of the {meaning}"),
            )
        },
        **{
            name: words
            for of in ("given", "simulated", "ratio")
            for name, words in (
                (f"{of}_exponent", f"exponent in the {of} wear rate"),
                (f"{of}_stderr", "its standard error"),
            )
        },
    ),
}
"""Tables of `abradem.calibration`."""


VERIFICATION = {
    **_columns("1", "int64", part="part of the study", steps="steps per contact",
               replicate="number of the replicate", facets="facets along the length",
               segment="segment of the chute, or axis of the impulse"),
    **_columns(
        "1", "string",
        law="what is compared", unit="unit of ours and reference", kind="kind of tolerance",
        verdict="whether the check holds", note="source, or choice that explains a difference",
        variant="options of the law", code="program", measure="wear measure", test="test",
        quantity="quantity", source="where the value is from", feed="kind of feed",
        scene="what is simulated", corner="radius and plate angle",
    ),
    **_columns(
        "1",
        ours="ours", plain="ours, integrated again",
        theirs="integrated again under the other code's choices", reference="reference",
        difference="difference, relative or in the unit",
        tolerance="tolerance", restitution="coefficient of restitution",
        static_friction="coefficient of static friction", rolling_friction="rolling friction",
        exact_beta="damping that rebounds at e", nominal_beta="textbook damping",
        rebound_exact="rebound with the exact damping",
        rebound_clipped="rebound with textbook damping, clipped",
        rebound_attractive="rebound with textbook damping, attractive",
        scaled="wear measure over m v^2", exact="exact value",
        tangential="tangential velocity after over speed before",
        spin_scaled="spin after times R over speed before",
        error="relative error against the converged step",
        fraction="step as a share of the Rayleigh time", bias="relative bias of the wear measure",
        bias_stderr="standard error of the bias",
        largest_bias="largest bias over materials, frictions and speeds",
        phase="phase at which the surfaces meet",
        value="value", exponent="exponent", exponent_stderr="standard error of the exponent",
        expected="expected value", relative_stderr="relative standard error",
        reference_stderr="relative standard error of the reference",
        r2="R2 of the cumulative wear against a straight line",
        covered="whether the interval holds the mean", steps_per_contact="steps per contact",
        factor="factor by which the quantity was changed",
    ),
    **_columns("W/m2", mean="mean over the plate", footprint="mean over the footprint",
               worn="mean over the worn elements",
               p99="99th percentile of the elements", max="worst element"),
    **_columns("deg", angle="angle from the normal", plate_angle="plate angle",
               factory_angle="factory angle", rebound_angle="rebound angle"),
    **_columns("m/s", speed="speed"),
    **_columns("rad/s", spin="spin"),
    **_columns("s", time="time"),
    **_columns("mm", depth="mean wear depth of the plate"),
    **_columns("mm/s", depth_rate="depth rate of the plate mean",
               depth_stderr="standard error of the depth rate"),
    **_columns("J", work="work"),
    **_columns("N s", spread="standard deviation between nudged particles of this engine"),
    **_columns("W", rate="rate of F_n ds, W = 1", rate_stderr="standard error of the rate"),
    **_columns("N", tangential_force="tangential force", normal_force="normal force",
        our_normal="normal force, ours", our_tangential="tangential force, ours",
        their_normal="normal force, integrated again under the other code's choices",
        their_tangential="tangential force, integrated again under the other code's choices"),
    **_columns("m", x="position along x", height="height over the plate", z="position along z"),
    **_columns("kg/s", mass_rate="mass rate"),
}  # fmt: skip
"""Tables of `abradem.verification`."""
