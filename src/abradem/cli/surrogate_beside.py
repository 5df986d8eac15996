"""The answer of a surrogate beside that of a simulation."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from abradem.cli.case_input import OwnSetup, headline
from abradem.cli.predict_words import rate_text, warn
from abradem.quantities import WEAR_COLUMNS, stderr_column
from abradem.surrogate.geometry_groups import shape_values
from abradem.surrogate.groups import input_names, jet_of
from abradem.surrogate.model import PredictionError, Surrogate


class SurrogateBeside:
    """A surrogate, and the set-up of the simulation that it is compared with."""

    def __init__(self, surrogate: Surrogate, stem: str, own: OwnSetup):
        self.surrogate, self.stem = surrogate, stem
        ours, theirs = jet_of(own.setup)._asdict(), surrogate.jet._asdict()
        geometries = [jet.pop("geometry") for jet in (ours, theirs)]
        # The jet of a table from elsewhere may be a reference alone.
        self.jet_known = surrogate.description.get("jet_known", True)
        target = surrogate.description["target"]
        of_elements = target["name"] in WEAR_COLUMNS and not target["name"].endswith("_mean")
        if of_elements:
            ours["element_size"] = headline(own.config).element_size
            theirs["element_size"] = target.get("element_size", ours["element_size"])
        self.differences = [
            f"{name} {theirs[name]} instead of {ours[name]}"
            for name in ours
            if ours[name] != theirs[name]
        ]
        if geometries[0] != geometries[1]:
            self.differences.append("another geometry")
        pairs = surrogate.description.get("pair_interaction", own.setup["pair_interaction"])
        if pairs != own.setup["pair_interaction"]:
            self.differences.append("other contacts between particles (pair_interaction)")

    def say(self, values: Mapping[str, float], rates) -> None:
        """Print the predictions for a case beside its simulated rates, one line for each rate."""
        found = self.surrogate.predict_all(values)
        first, *_ = found.values()
        warn(first.warnings)
        if not self.jet_known:
            warn(["the surrogate was trained with a table whose jet is not known"])
        elif self.differences:
            warn([f"the surrogate was trained with another set-up: {', '.join(self.differences)}"])
        for name, prediction in found.items():
            line = f"surrogate {self.stem}: {rate_text(self.surrogate, name, prediction)}"
            # The rates of a simulation are those of the whole surface.
            if name in rates and not self.surrogate.models[name].target.get("part"):
                unit = self.surrogate.models[name].target["unit"]
                line += (
                    f"; simulated {rates[name]:.4g} {unit}, standard error "
                    f"{rates[stderr_column(name)]:.2g} {unit}"
                )
            print(line)


def surrogate_beside(
    model: str | None, own: OwnSetup, values: Mapping[str, float]
) -> SurrogateBeside | None:
    """Return the surrogate that is given, or that of the study if it exists, or None.

    Raises
    ------
    PredictionError
        If a surrogate cannot be read, or is given for another kind of surface.
    """
    stem = model or f"results/{own.config.study}/models/surrogate"
    if model is None and not Path(f"{stem}.json").is_file():
        return None
    surrogate = Surrogate.load(stem)
    if model is None and _kind(surrogate.jet.geometry) != _kind(own.setup.get("geometry")):
        return None
    check_geometry(surrogate, stem, own, values)
    return SurrogateBeside(surrogate, stem, own)


def check_geometry(surrogate: Surrogate, stem: str, own: OwnSetup, values: Iterable[str]) -> None:
    """Raise `PredictionError` if a surrogate predicts another kind of surface than that of a case.

    Parameters
    ----------
    surrogate : Surrogate
    stem : str
        Its files, for the message.
    own : OwnSetup
    values : iterable of str
        The quantities of the case.
    """
    theirs, ours = surrogate.jet.geometry, own.setup.get("geometry")
    if _kind(theirs) != _kind(ours):
        raise PredictionError(
            f"{stem}: predicts the wear of a surface of kind {_kind(theirs)}, this case has "
            f"{_kind(ours)} (allowed: the surrogate of a study of that kind)"
        )
    lacking = [name for name in input_names(surrogate.jet) if name not in values]
    if lacking:
        raise PredictionError(f"{stem}: the case has no {', '.join(lacking)}")


def _kind(geometry: Mapping | None) -> str:
    return shape_values(geometry).get("kind", "plate")
