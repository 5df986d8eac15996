"""Everything that is named in a figure or in the report has a label."""

import pytest

from abradem.learning.comparison import ORDER
from abradem.learning.physical.models import MODELS as PHYSICAL_MODELS
from abradem.learning.physical.power_law import SHARES, PowerLaw
from abradem.learning.protocols import PROTOCOLS as PROTOCOL_NAMES
from abradem.quantities import (
    GEOMETRY_GROUPS,
    GEOMETRY_NAMES,
    QUANTITIES,
    STATISTICS,
    WEAR_COLUMNS,
    WEAR_MEASURES,
    Quantity,
)
from abradem.store.columns import COLUMNS
from abradem.surrogate.groups import GROUP_NAMES
from abradem.words import labels
from abradem.words.wear import WEAR_WORDS


def test_every_quantity_and_every_term_of_the_power_law_has_a_label():
    assert {row.name for row in QUANTITIES} | set(GEOMETRY_NAMES) <= labels.LABELS.keys()
    assert SHARES.keys() <= labels.LABELS.keys()
    law = PowerLaw((*GROUP_NAMES, *GEOMETRY_GROUPS.values()))
    assert labels.GROUP_LABELS.keys() == {"constant", *law.terms}


def test_every_model_and_every_protocol_has_a_name():
    assert tuple(labels.MODELS) == ORDER
    assert labels.PROTOCOLS.keys() == set(PROTOCOL_NAMES)


def test_every_wear_rate_has_words():
    assert tuple(labels.MEASURE_WORDS) == WEAR_MEASURES
    assert tuple(labels.STATISTIC_WORDS) == STATISTICS
    assert WEAR_WORDS.keys() == set(WEAR_COLUMNS)


@pytest.mark.parametrize("name", [row.name for row in QUANTITIES])
def test_long_names_in_the_metadata_of_tables_are_the_labels(name):
    words = WEAR_WORDS.get(name, labels.LABELS[name].long_name)
    assert COLUMNS[name].long_name == words


def test_the_table_of_quantities_holds_numbers_and_units_alone():
    assert not {"tex", "long_name", "label"} & set(Quantity.__dataclass_fields__)


def test_the_models_on_groups_are_those_of_the_physics():
    assert set(labels.ON_GROUPS) == {*PHYSICAL_MODELS, "surrogate"}
    assert set(labels.ON_GROUPS) < set(labels.MODELS)
