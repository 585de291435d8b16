"""The table beside other programs' numbers, and what many spectra cost."""

import pytest

from hradiosity.model.spectrum import Bands
from hradiosity.suites.colour_table import seconds_of_many, table, table_lines

WHOLE = Bands.uniform(360, 830, 5)


def test_all_numbers_are_within_their_tolerances_but_ratios_of_lamps_with_mercury_lines():
    """Those lamps are tabulated every 5 nm by CIE 15; the other program has a table every 1 nm of its own."""
    lines = table(WHOLE)
    assert len(lines) == 22
    outside = {line.light: line.outside for line in lines if line.outside}
    assert all(light.startswith("FL") and columns == ("DER",) for light, columns in outside.items())
    assert max(line.deviation.get("DER", 0.0) for line in lines) < 2e-3
    assert len(table_lines(lines)) == 24


@pytest.mark.parametrize(("full", "most"), [(False, 0.6), (True, 2.5)])
def test_ten_thousand_spectra(full, most):
    assert min(seconds_of_many(Bands.uniform(), full=full) for _ in range(2)) < most
