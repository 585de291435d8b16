"""The benchmark of form factors measures what it says."""

import numpy as np

from hradiosity.suites.bench_form_factors import BOX_TOLERANCES, box_squares, run_box, run_catalogue
from hradiosity.suites.validation.data import form_factors
from hradiosity.transport.form_factor.methods import METHODS


def test_box(device):
    squares = box_squares(3)
    assert squares.shape == (54, 4, 3)
    inward = np.einsum(
        "nd,nd->n", np.cross(squares[:, 1] - squares[:, 0], squares[:, 2] - squares[:, 0]), 0.5 - squares[:, 0]
    )
    assert (inward > 0.0).all()
    rows = [row for row in run_box(device, 3, 1) if row.name.startswith("auto")]
    assert len(rows) == len(BOX_TOLERANCES)
    assert all(row.error < tolerance and row.seconds > 0.0 for row, tolerance in zip(rows, BOX_TOLERANCES))


def test_catalogue(device):
    """A few easy entries, which every method takes."""
    easy = [entry for entry in form_factors() if entry["id"] in ("P03", "O05")]
    rows = run_catalogue(device, easy)
    assert [row.method for row in rows] == list(METHODS)
    assert all(set(row.worst) == {"parallel-opposed", "parallel-offset"} for row in rows)
    assert all(max(row.worst.values()) < 0.7 and row.microseconds > 0.0 for row in rows)
    assert max(rows[METHODS.index("contour")].worst.values()) < 1e-12
