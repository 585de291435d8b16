"""Form factors by a hemisphere of flat pieces: the projected edges become chords, no arc function is needed."""

from __future__ import annotations

import numpy as np

from hradiosity.transport.form_factor.hemisphere import receiver_sum
from hradiosity.transport.form_factor.pairs import Estimate, Pairs
from hradiosity.transport.form_factor.receiver_error import points_error


def quasi_hemisphere_exchange(pairs: Pairs, points: int, chords: int) -> Estimate:
    """A F of pairs with the projection of each edge on the hemisphere replaced by equal chords.

    The polygon of the chords lies inside the true projection; its area is short by the square of the angle that a
    chord spans.

    Parameters
    ----------
    pairs : Pairs
    points : int
        Gauss points a direction on each quadrilateral of the first polygon.
    chords : int
        For each edge; the next power of 2 is taken.
    """
    halvings = int(np.ceil(np.log2(chords)))
    value = receiver_sum(pairs, points, halvings)
    points_off = points_error(value, points, lambda order, line: receiver_sum(pairs, order, halvings, line))
    other_chords = receiver_sum(pairs, points, halvings - 1 if halvings else 1)
    return Estimate(value, points_off + np.abs(value - other_chords))
