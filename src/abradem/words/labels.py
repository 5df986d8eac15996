"""Display names of quantities, groups, models and protocols for figures, tables and the report.

No result depends on this package. An edit here redraws figures and rewrites the report, but
repeats no simulation and trains no model.
"""

from __future__ import annotations

from typing import NamedTuple

from abradem.quantities import GEOMETRY_GROUPS, MOST_PLATES, WEAR_COLUMNS, quantity


class Label(NamedTuple):
    """Mathematical symbol in TeX, without dollar signs, and the name for an axis."""

    tex: str
    long_name: str


_OF_PLATE = {
    "length": Label("l", "length"),
    "width": Label("b", "width"),
    "angle": Label(r"\varphi", "angle"),
    "gap": Label("x", "gap before"),
    "drop": Label("h", "drop before"),
    "belt": Label("u", "belt speed"),
}

GEOMETRY_LABELS: dict[str, Label] = {
    **{
        f"plate_{place}_{name}": Label(
            f"{label.tex}_{place}",
            f"{label.long_name} {'' if 'before' in label.long_name else 'of '}plate {place}",
        )
        for place in range(1, MOST_PLATES + 1)
        for name, label in _OF_PLATE.items()
    },
    "arc_radius": Label("R_a", "radius of the arc"),
    "arc_begin": Label(r"\alpha_0", "slope where the arc begins"),
    "arc_end": Label(r"\alpha_1", "slope where the arc ends"),
    "arc_width": Label("b_a", "width of the arc"),
    "screw_length": Label("l_s", "length of the screw"),
    "screw_radius": Label("R_s", "radius of the flight"),
    "screw_shaft_radius": Label("r_s", "radius of the shaft"),
    "screw_pitch": Label("p_s", "pitch of the screw"),
    "screw_clearance": Label("c_s", "clearance of the flight"),
    "screw_rim": Label("h_s", "height of the trough's walls"),
    "screw_revolutions": Label("n_s", "speed of rotation of the screw"),
}
"""Labels of the quantities of a geometry."""

LABELS: dict[str, Label] = {
    "particle_youngs_modulus": Label("E_p", "particle Young's modulus"),
    "particle_shear_modulus": Label("G_p", "particle shear modulus"),
    "particle_poisson_ratio": Label(r"\nu_p", "particle Poisson's ratio"),
    "particle_density": Label(r"\rho_p", "particle density"),
    "equipment_youngs_modulus": Label("E_e", "plate Young's modulus"),
    "equipment_shear_modulus": Label("G_e", "plate shear modulus"),
    "equipment_poisson_ratio": Label(r"\nu_e", "plate Poisson's ratio"),
    "equipment_density": Label(r"\rho_e", "plate density"),
    "restitution": Label("e", "coefficient of restitution"),
    "rolling_friction": Label(r"\mu_r", "coefficient of rolling friction"),
    "static_friction": Label(r"\mu_s", "coefficient of static friction"),
    "archard_constant": Label("W", "Archard wear constant"),
    "plate_angle": Label(r"\varphi", "plate angle"),
    "factory_angle": Label(r"\theta", "factory angle"),
    "particle_radius": Label("R", "particle radius"),
    "particle_velocity_y": Label("v_y", "particle velocity (vertical)"),
    "effective_youngs_modulus": Label("E^*", "effective Young's modulus"),
    "effective_shear_modulus": Label("G^*", "effective shear modulus"),
    "damping_ratio": Label(r"\xi", "damping ratio"),
    "damping_coefficient": Label(r"\eta", "damping coefficient"),
    **dict.fromkeys(WEAR_COLUMNS, Label(r"\dot h", "wear depth rate")),
    "impact_speed": Label("v", "speed of impact"),
    **GEOMETRY_LABELS,
}
"""Labels of the quantities of `abradem.quantities`, of all wear rates and of the impact speed."""

POWER_LABELS: dict[str, Label] = {
    **LABELS,
    "impact_speed": Label("v^2 + 2 g H", "squared speed of impact"),
    "restitution": Label("1 + e", "1 + coefficient of restitution"),
}
"""Labels of what has an exponent in a wear rate, see `abradem.dataset.power_fit`."""


def _geometry_group(name: str, group: str) -> Label:
    """Label of the group of a quantity of a geometry."""
    tex, words = GEOMETRY_LABELS[name]
    if group.startswith("log_"):
        return Label(rf"\ln {tex}/H", f"{words} over the fall height")
    if name == "screw_revolutions":
        return Label(r"u_s/v", "rim speed of the screw over the speed of impact")
    if name.endswith("_belt"):
        return Label(f"{tex}/v", f"{words} over the speed of impact")
    if group.endswith("_ratio"):
        return Label(f"{tex}/H", f"{words} over the fall height")
    return Label(tex, words)


_GEOMETRY_GROUP_LABELS: dict[str, Label] = {
    group: _geometry_group(name, group) for name, group in GEOMETRY_GROUPS.items()
}

GROUP_LABELS: dict[str, Label] = {
    "constant": Label(r"\ln C", "constant"),
    "log_froude": Label(r"\ln Fr", "Froude number of the impact"),
    "log_size": Label(r"\ln R/H", "radius over fall height"),
    "log_loading": Label(r"\ln L", "loading of the jet"),
    "log_cauchy": Label(r"\ln Ca", "Cauchy number of the impact"),
    "log_stiffness_ratio": Label(r"\ln G^*/E^*", "tangential over normal stiffness"),
    "log_static_friction": Label(r"\ln \mu_s", "static friction"),
    "log_rolling_friction": Label(r"\ln \mu_r", "rolling friction"),
    "log_rebound": Label(r"\ln (1+e)", "restitution"),
    "plate_angle": Label(r"\varphi", "plate angle"),
    "jet_width": Label(r"\cos\theta", "width of the jet"),
    "plate_angle_squared": Label(r"\varphi^2", "square of the plate angle"),
    **_GEOMETRY_GROUP_LABELS,
    **{
        f"{name}_squared": Label(f"{tex}^2", f"square of the {words}")
        for name, (tex, words) in _GEOMETRY_GROUP_LABELS.items()
        if name in GEOMETRY_LABELS
    },
}
"""Labels of the terms of the power law: the constant and the groups of `abradem.surrogate`."""

MEASURE_WORDS = {
    "total": "all tangential motion under load",
    "sliding": "slip at Coulomb's limit",
    "friction": "friction work over the coefficient of friction",
}
"""Descriptions of the wear measures of `abradem.quantities.WEAR_MEASURES`."""

STATISTIC_WORDS = {
    "mean": "mean over the plate",
    "worn": "mean over the worn elements",
    "footprint": "mean over the footprint",
    "p99": "99th percentile of the elements",
    "max": "worst element",
}
"""Descriptions of the statistics over the plate of `abradem.quantities.STATISTICS`."""

SURFACES = {
    "plate": "an inclined plate",
    "plates": "a chain of plates",
    "arc": "a curved chute",
    "mesh": "a triangulated surface",
    "screw": "a screw conveyor",
}
"""What the particles wear, by kind of geometry."""

PROTOCOLS = {"as_published": "as published", "leakage_free": "leakage-free"}
"""Display names of the protocols of `abradem.learning.protocols`."""

MODELS = {
    "linear": "least squares",
    "lasso": "lasso",
    "ridge": "ridge",
    "pca_wrong_target": "PCA, wrong target",
    "pca": "PCA regression",
    "tree": "decision tree",
    "forest": "random forest",
    "paper_net": "449-24-500-385 net",
    "ga_ann": "GA-ANN",
    "power_law": "power law",
    "boosting": "boosting",
    "networks": "network ensemble",
    "gaussian_process": "Gaussian process",
    "stacked": "process + boosting",
    "surrogate": "surrogate (distilled)",
}
"""Display names of the models of `abradem.learning`, by their names in the tables."""

ON_GROUPS = ("power_law", "boosting", "networks", "gaussian_process", "stacked", "surrogate")
"""The models on dimensionless groups; the others learn from the features of the paper."""


def feature_label(name: str) -> str:
    """X number, if it has one, and symbol of a quantity, such as ``X13  $\\varphi$``."""
    if name in GEOMETRY_LABELS:
        return f"${LABELS[name].tex}$"
    return f"{quantity(name).symbol}  ${LABELS[name].tex}$"
