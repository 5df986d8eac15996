"""Declaration of the configuration: every key with its default, unit and allowed values.

The sections are in modules of their own, ``..._keys``.
"""

from __future__ import annotations

from pydantic import Field

from abradem.config.batches import batches_of_block
from abradem.config.fields import Section, setting
from abradem.config.figure_keys import Figures
from abradem.config.learning_keys import Features, Learning, WearRate
from abradem.config.publish_keys import Publish
from abradem.config.sampling_keys import Sampling
from abradem.config.scalars import STUDY_NAME
from abradem.config.simulation_keys import Simulation
from abradem.config.table_keys import Calibration, Dataset


class Config(Section):
    """A study. `read_config` also checks conditions that involve several keys."""

    study: str = setting(
        ...,
        "Name of the study; its results are in results/<study>/.",
        allowed="letters, digits, _ and -, beginning with a letter or digit, at most 64",
        pattern=STUDY_NAME,
    )
    seed: int = setting(
        1,
        "Seed of all random numbers; the same seed gives the same results.",
        ge=0,
        le=2**63 - 1,
    )
    sampling: Sampling = Field(
        default_factory=Sampling, description="Which parameter sets are simulated."
    )
    simulation: Simulation = Field(
        default_factory=Simulation, description="All settings that are not sampled."
    )
    wear_rate: WearRate = Field(
        default_factory=WearRate, description="Wear rates and their quality."
    )
    dataset: Dataset = Field(
        default_factory=Dataset, description="Your own table instead of simulations."
    )
    features: Features = Field(default_factory=Features, description="The derived quantities.")
    learning: Learning = Field(default_factory=Learning, description="Models of the data set.")
    calibration: Calibration = Field(
        default_factory=Calibration, description="Search for the set-up that explains a table."
    )
    figures: Figures = Field(default_factory=Figures, description="The figures of the report.")
    publish: Publish = Field(
        default_factory=Publish, description="Metadata of the published data set."
    )

    @property
    def cases(self) -> int:
        """Number of cases of the study."""
        return self.sampling.blocks * self.sampling.cases_per_block

    @property
    def batches(self) -> list[tuple[int, int]]:
        """First case and last case plus one of each batch of a block, see `config.batches`."""
        return batches_of_block(self.sampling.cases_per_block, self.simulation.cases_per_job)

    @property
    def jobs(self) -> int:
        """Number of simulation jobs: the batches of all blocks."""
        return self.sampling.blocks * len(self.batches)

    @property
    def threads(self) -> int:
        """Number of threads of a simulation job; with a geometry one, as the engine uses one."""
        return self.simulation.threads if self.simulation.geometry.kind == "plate" else 1
