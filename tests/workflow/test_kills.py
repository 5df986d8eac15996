"""A few tests of `make kills`: a killed study resumes without loss."""

import pytest
from kills import one_kill, undisturbed


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    """Tables of an undisturbed study, and its run time."""
    return undisturbed(tmp_path_factory.mktemp("kills") / "undisturbed")


@pytest.mark.parametrize("kind", ["anywhere", "table", "orphans"])
def test_a_study_that_is_killed_and_resumed_holds_the_same_bytes(expected, tmp_path, kind):
    one_kill(tmp_path / "killed", kind, 0, *expected)


def test_of_two_runs_of_a_study_one_goes_away_and_nothing_is_lost(expected, tmp_path):
    one_kill(tmp_path / "twice", "twice", 0, *expected)
