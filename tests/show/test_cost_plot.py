"""The picture of prices: there for any report, and legible."""

import io
import math
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Annotation, Text
from PIL import Image

from hradiosity.show.cost_plot import GROUPS, BandsPoint, CostPicture, CostPoint, draw_costs
from hradiosity.show.labels import label_points


def point(group, seconds, error, **changes):
    errors = (error, 2 * error, 4 * error)
    efforts = dict.fromkeys(GROUPS, seconds)
    usual = CostPoint(f"{group} {seconds:g}", group, seconds, 2**27, errors, errors, False, False, True, True, efforts)
    return replace(usual, **changes)


EVERY = [point(group, 1.0 + k, 0.1 / (1 + k)) for k, group in enumerate(GROUPS)]
BANDS = [BandsPoint(9, 1.0, 0.01, 0.002, 80.0, 2.0, 0.03), BandsPoint(401, 4.0, *[0.0] * 5)]
COLOURLESS = [BandsPoint(9, 1.0, 0.01, 0.002, math.nan, math.nan, math.nan), BANDS[1]]


def pixels(picture):
    return np.asarray(Image.open(io.BytesIO(draw_costs(picture))).convert("RGB"))


@pytest.mark.parametrize(
    "picture",
    [
        CostPicture("all", EVERY, 0.002, 0.003, BANDS),
        CostPicture("one", EVERY[:1], 0.2, 0.3, []),
        CostPicture("no colour", EVERY[:3], 0.2, 0.3, COLOURLESS),
        CostPicture("no noise", EVERY[:2], 0.0, 0.0, BANDS[:1]),
        CostPicture("no memory", [replace(p, memory_bytes=None) for p in EVERY], 0.002, 0.002, []),
        CostPicture("hidden", [replace(p, illuminance_hidden=True, on_front=False) for p in EVERY], 0.5, 0.5, []),
    ],
    ids=lambda picture: picture.title,
)
def test_any_report_can_be_drawn(picture):
    drawn = pixels(picture)
    assert drawn.shape[0] > 900 and drawn.shape[1] > 1300
    assert len(np.unique(drawn.reshape(-1, 3), axis=0)) > 50


@pytest.mark.parametrize(("front", "hidden"), [(0, 0), (1, 0), (2, 0), (2, 1)])
def test_legend_names_what_is_drawn(front, hidden, monkeypatch):
    labels = []
    monkeypatch.setattr(Figure, "legend", lambda self, handles, **_: labels.extend(h.get_label() for h in handles))
    changes = [
        {"on_front": k < front, "on_spectral_front": False, "spectrum_hidden": k < hidden} for k in range(len(EVERY))
    ]
    draw_costs(CostPicture("some", [replace(p, **c) for p, c in zip(EVERY, changes)], 0.01, 0.01, []))
    assert ("Pareto front" in labels, "not to be told from the noise" in labels) == (front > 1, hidden > 0)


def test_groups_differ():
    assert len(set(GROUPS.values())) == len(GROUPS) == len({mark for _, mark in GROUPS.values()})


def test_names_cover_neither_each_other_nor_marks():
    rng = np.random.default_rng(3)
    marks = [(float(x), float(y)) for x, y in rng.uniform(0.2, 0.8, (14, 2))]
    figure = Figure(figsize=(8, 6))
    canvas = FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.plot(*zip(*marks), "o")
    axes.set(xlim=(0, 1), ylim=(0, 1))
    canvas.draw()
    label_points(axes, [(x, y, f"setting {k}") for k, (x, y) in enumerate(marks)], marks, canvas.get_renderer())
    names = [child for child in axes.get_children() if isinstance(child, Annotation)]
    assert len(names) >= 12
    extents = [Text.get_window_extent(name, canvas.get_renderer()) for name in names]
    for k, one in enumerate(extents):
        assert not any(one.overlaps(other) for other in extents[:k])
        for mark in marks:
            assert not one.contains(*axes.transData.transform(mark))
