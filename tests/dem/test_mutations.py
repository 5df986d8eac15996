"""Mutation tests: an error inserted into a copy of the engine makes a named check fail."""

import pytest
from planted_errors import ERRORS, caught


@pytest.mark.parametrize("name", [e.name for e in ERRORS if e.quick])
def test_a_planted_error_is_caught(name, tmp_path):
    error = next(e for e in ERRORS if e.name == name)
    verdict = caught(error, tmp_path)
    assert error.check in verdict, verdict
