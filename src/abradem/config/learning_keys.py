"""Keys of `wear_rate`, `features` and `learning`: rates and their models."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from abradem.config.fields import Section, Text, setting
from abradem.quantities import STATISTICS, WEAR_MEASURES


class WearRate(Section):
    """Wear rates and their quality, from the worn volume over time."""

    min_batches: int = setting(
        20,
        "Smallest number of equal batches for a rate and its standard error; twice as many "
        "are used where the samples suffice.",
        ge=20,
        le=10_000,
    )
    footprint_share: float = setting(
        0.95,
        "The footprint is the smallest set of elements with this share of the wear.",
        gt=0.0,
        le=1.0,
    )
    element_size_mm: float | None = setting(
        30.0,
        "Edge of the elements of the statistics worn, footprint, p99 and max: a whole number of "
        "facets, and a whole part of the plate. null: the facets.",
        unit="mm",
        gt=0.0,
        le=100_000.0,
    )
    good_r2: float = setting(
        0.95,
        "A series counts as good if the R2 of its straight line is at least this.",
        ge=0.0,
        le=1.0,
    )
    reference_mm_s: float | None = setting(
        None,
        "Depth rate from elsewhere that the rates of the parts of a geometry are put beside.",
        unit="mm/s",
        gt=0.0,
        le=1000.0,
    )
    reference_source: Text | None = setting(
        None, "Who states reference_mm_s, as written in the answer.", allowed="a text or null"
    )


class Features(Section):
    """The derived quantities."""

    damping_coefficient: Literal["table", "printed"] = setting(
        "table",
        "Formula of X20. table: 2 sqrt(5/6) xi sqrt(m k) with k = 4/3 E* R, as in the data of the "
        "paper (negative). printed: -2 sqrt(m k_n) ln e / sqrt(ln^2 e + pi^2), as printed in the "
        "paper.",
    )


TARGETS = tuple(
    f"wear_{measure}_{statistic}" for measure in WEAR_MEASURES for statistic in STATISTICS
)


class Penalised(Section):
    """Lasso and ridge.

    As published, the penalties are given below; leakage-free, they are cross-validated.
    """

    lasso_alpha: float = setting(0.1, "Penalty of the lasso as published.", gt=0.0, le=1e6)
    ridge_alpha: float = setting(1.0, "Penalty of the ridge as published.", gt=0.0, le=1e6)
    path_points: int = setting(40, "Number of penalties tried on each path.", ge=5, le=1000)


class Selection(Section):
    """Selection of the input features of the networks."""

    features: int = setting(12, "Number of selected features.", ge=2, le=20)


class Trees(Section):
    """Decision tree and random forest."""

    max_depth: int = setting(49, "Largest depth in the curve of score over depth.", ge=1, le=100)
    forest_trees: int = setting(100, "Number of trees in the forest.", ge=1, le=10_000)


class GaAnn(Section):
    """Networks with an architecture that is found by a genetic search."""

    population: int = setting(10, "Networks per generation.", ge=2, le=1000)
    generations: int = setting(25, "Generations per search.", ge=1, le=10_000)
    min_layers: int = setting(2, "Smallest number of hidden layers.", ge=1, le=20)
    max_layers: int = setting(6, "Largest number of hidden layers.", ge=1, le=20)
    min_neurons: int = setting(10, "Smallest number of neurons per layer.", ge=1, le=10_000)
    max_neurons: int = setting(500, "Largest number of neurons per layer.", ge=1, le=10_000)
    selection: Literal["tournament", "roulette"] = setting(
        "tournament",
        "Selection of parents: tournament takes the best of a few random networks, roulette "
        "draws with a probability proportional to the fitness.",
    )
    tournament_size: int = setting(3, "Networks per tournament.", ge=1, le=1000)
    crossover: float = setting(0.9, "Probability that two parents exchange layers.", ge=0.0, le=1.0)
    mutation: float = setting(
        0.2,
        "Probability that one layer of a child and its start weights change.",
        ge=0.0,
        le=1.0,
    )
    mutation_size: float = setting(
        0.2, "Largest relative change of the number of neurons in that layer.", gt=0.0, le=1.0
    )
    elites: int = setting(1, "Number of best networks that are kept unchanged.", ge=0, le=999)
    weights: Literal["seed", "inherited"] = setting(
        "seed",
        "Start weights of a child: random from a seed, or the trained weights of its first "
        "parent, as far as the layers overlap.",
    )
    epochs: int = setting(20, "Epochs of a training during the search.", ge=1, le=100_000)
    batch: int = setting(32, "Rows per mini-batch during the search.", ge=1, le=1_000_000)
    final_epochs: int = setting(60, "Epochs of a training of the best network.", ge=1, le=100_000)
    final_batch: int = setting(50, "Rows per mini-batch for the best network.", ge=1, le=1_000_000)
    learning_rate: float = setting(0.001, "Learning rate of the optimiser (Adam).", gt=0.0, le=1.0)
    validation_share: float = setting(
        0.25,
        "Share of the training rows that the fitness is computed on (leakage-free).",
        ge=0.05,
        le=0.9,
    )
    retrainings: int = setting(
        10, "Trainings of the best network from different start weights.", ge=1, le=1000
    )
    searches: int = setting(
        5,
        "Number of leakage-free searches, each in the training rows of a different split, which "
        "take that many times as long as one; at most one for each of learning.repeats splits. On "
        "all other splits the network found by the first search is trained and scored.",
        ge=1,
        le=1000,
    )
    device: Literal["cpu", "cuda"] = setting(
        "cpu",
        "Device for the training of networks: cpu trains one per core, cuda trains batches of "
        "networks on a GPU.",
    )


class Physical(Section):
    """Physics-informed models of the wear number on dimensionless groups, and their intervals."""

    boosting_trees: int = setting(400, "Number of boosted trees.", ge=1, le=100_000)
    boosting_depth: int = setting(4, "Largest depth of a boosted tree.", ge=1, le=50)
    networks: int = setting(4, "Networks in the ensemble.", ge=1, le=1000)
    network_steps: int = setting(
        1000, "Number of mini-batches that each network is trained on.", ge=1, le=10_000_000
    )
    interval_folds: int = setting(
        10,
        "Folds for the calibration and the test of the prediction intervals.",
        ge=2,
        le=1000,
    )
    target_repeats: int = setting(
        5,
        "Random splits for the scores of every target, and number of permutations.",
        ge=1,
        le=10_000,
    )
    curve_repeats: int = setting(10, "Random splits for the learning curve.", ge=1, le=10_000)
    sobol_points: int = setting(
        2048,
        "Number of base points for the Sobol indices.",
        ge=8,
        le=2**20,
        allowed="a power of two from 8 to 1048576",
    )


class Noise(Section):
    """Repeated simulations with other seeds, for the random part of a simulated wear rate."""

    cases: int = setting(
        10, "Number of repeated cases, among those with large particles.", ge=1, le=10_000
    )
    replicates: int = setting(8, "Simulations of each of these cases.", ge=1, le=10_000)


class SurrogateModel(Section):
    """The small network that `abradem predict` uses."""

    points: int = setting(
        20_000,
        "Number of points at which it is trained on the Gaussian process.",
        ge=100,
        le=10_000_000,
    )
    hidden: list[Annotated[int, Field(ge=1, le=10_000)]] = setting(
        [64, 64],
        "Number of neurons in each hidden layer.",
        allowed="a list of numbers from 1 to 10000",
        min_length=1,
        max_length=10,
    )
    epochs: int = setting(40, "Epochs of the training.", ge=1, le=100_000)
    timed_cases: int = setting(
        5,
        "Cases that are simulated again to compare the run times of engine and network.",
        ge=1,
        le=10_000,
    )


class Learning(Section):
    """Models of the data set, each as published and leakage-free (docs/learning.md)."""

    target: Literal[TARGETS] = setting(  # type: ignore[valid-type]  # names of a table
        "wear_friction_p99", "Column of the data set to predict."
    )
    part: Text | None = setting(
        None,
        "Named part of simulation.geometry whose wear the models explain, such as a plate of a "
        "chain or a solid of a mesh; null: the whole surface. The rates of a part have no standard "
        "error.",
        allowed="the name of a part or null",
    )
    test_share: float = setting(
        0.2, "Share of the cases held out as test set of each fit (leakage-free).", ge=0.05, le=0.9
    )
    repeats: int = setting(
        20, "Number of random training/test splits for the scores of a model.", ge=1, le=10_000
    )
    folds: int = setting(5, "Folds of the cross-validation in the training rows.", ge=2, le=1000)
    confidence: float = setting(0.95, "Confidence level of all intervals.", ge=0.5, le=0.9999)
    bootstrap: int = setting(
        2000,
        "Bootstrap samples of the test rows for the interval of a single split.",
        ge=100,
        le=1_000_000,
    )
    fresh_blocks: int = setting(
        0,
        "Blocks of cases simulated for the test of the prediction intervals alone, and seen by no "
        "model; 0: none. Two blocks of 100 cases tell shares of regions apart.",
        ge=0,
        le=1000,
    )
    penalised: Penalised = Field(default_factory=Penalised, description="Lasso and ridge.")
    selection: Selection = Field(
        default_factory=Selection, description="Selection of the input features of the networks."
    )
    trees: Trees = Field(default_factory=Trees, description="Decision tree and random forest.")
    ga_ann: GaAnn = Field(
        default_factory=GaAnn,
        description="Networks with an architecture that is found by a genetic search.",
    )
    physical: Physical = Field(
        default_factory=Physical,
        description="Physics-informed models on dimensionless groups (docs/physical.md).",
    )
    noise: Noise = Field(
        default_factory=Noise, description="Repeated simulations for the random part of a rate."
    )
    surrogate: SurrogateModel = Field(
        default_factory=SurrogateModel, description="The model that `abradem predict` uses."
    )
