"""The report on disk: ``cost.csv``, ``bands.csv``, ``cost.json``, ``cost.md``, ``cost.png``."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from hradiosity.io.output_folder import write_file
from hradiosity.io.run_record import to_json
from hradiosity.show.cost_plot import BandsPoint, CostPicture, CostPoint, draw_costs
from hradiosity.suites.cost.pareto import pareto_front, quotes
from hradiosity.suites.cost.pricing import costs_and_errors, front_of
from hradiosity.suites.cost.settings import efforts_of
from hradiosity.suites.cost.values import BandsPrice, Price, Report
from hradiosity.suites.cost.words import (
    Rows,
    bands_rows,
    effect_rows,
    markdown,
    price_rows,
    recommendation,
    reference_line,
    share_text,
    skipped_lines,
    solver_rows,
)

COLUMNS = (
    *("setting", "group", "flags", "on_front", "cpu_s", "wall_s", "memory_bytes", "elements", "seeds"),
    *("illuminance_rms", "illuminance_p95", "illuminance_max", "illuminance_below_noise"),
    *("spectrum_rms", "spectrum_p95", "spectrum_max", "spectrum_below_noise", "bias", "sampling"),
)
BANDS_COLUMNS = (
    *("bands", "columns", "cpu_s", "illuminance_rms", "mean_illuminance", "chromaticity_rms"),
    *("cct_rms_k", "ra_rms", "mean_melanopic_edi"),
)


def write_cost(folder: Path, report: Report) -> None:
    """All files of a report into a folder that exists.

    Raises
    ------
    OutputError
        When one can't be written.
    """
    write_file(folder / "cost.csv", cost_table(report.prices))
    write_file(folder / "bands.csv", bands_table(report.bands))
    write_file(folder / "cost.json", (to_json(cost_record(report), indent=1) + "\n").encode())
    write_file(folder / "cost.md", "\n".join([*markdown_lines(report), ""]).encode())
    write_file(folder / "cost.png", draw_costs(picture_of(report)))


def cost_table(found: Iterable[Price]) -> bytes:
    """``cost.csv``: one row a setting; errors and bias relative, without the referee's noise."""
    return _csv(COLUMNS, map(_cells, found))


def bands_table(found: Iterable[BandsPrice]) -> bytes:
    """``bands.csv``: one row a number of bands; changes against the last row, powers relative, empty if unknown."""
    rows = (
        (
            *(price.bands, price.columns, _short(price.cpu_seconds)),
            *(_short(price.illuminance), _short(price.mean_illuminance), _short(price.chromaticity)),
            *(_short(x) if math.isfinite(x) else "" for x in (price.cct, price.ra, price.melanopic)),
        )
        for price in found
    )
    return _csv(BANDS_COLUMNS, rows)


def _csv(head: Sequence[str], rows: Iterable[Sequence[Any]]) -> bytes:
    """A table as a file."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return text.getvalue().encode()


def cost_record(report: Report) -> dict[str, Any]:
    """``cost.json``: everything."""
    cost, error = costs_and_errors(report.prices)
    names = [price.setting.name for price in report.prices]
    known = {name: value for name, value in asdict(report).items() if name != "prices"}
    return known | {
        "prices": [dict(zip(COLUMNS, _cells(price))) for price in report.prices],
        "recommendation": recommendation(report),
        "quotes": [
            asdict(one) | {"setting": None if one.setting is None else names[one.setting]}
            for one in quotes(cost, error)
        ],
    }


def tables(report: Report) -> list[tuple[str, Rows]]:
    """Titles and rows of all tables that hold something."""
    named = [
        ("Settings, by rising cost (* nothing is both cheaper and better)", price_rows(report.prices)),
        ("Solvers: the light on the surfaces, one replicate", solver_rows(report)),
        ("Effects forced against the plan", effect_rows(report)),
        (_bands_title(report), bands_rows(report) if len(report.bands) > 1 else []),
    ]
    return [(title, rows) for title, rows in named if len(rows) > 1]


def _bands_title(report: Report) -> str:
    """With the noise that the readings, unlike their mean, may differ by from one number of bands to another."""
    draft = next((price.sampling for price in report.prices if price.setting.name == "draft"), None)
    return "Numbers of bands" + ("" if draft is None else f", by drafts whose own noise is {share_text(draft)}")


def markdown_lines(report: Report) -> list[str]:
    """The whole report as Markdown."""
    lines = [f"# What accuracy costs: {report.scene}", "", *(f"* {line}" for line in recommendation(report)), ""]
    lines += [reference_line(report) + ".", f"Device: {report.device}."]
    for title, rows in tables(report):
        lines += ["", f"## {title}", "", *markdown(rows)]
    if report.skipped:
        lines += ["", "## Not run", "", *skipped_lines(report.skipped)]
    return lines


def picture_of(report: Report) -> CostPicture:
    """What the plot shows."""
    spectral = costs_and_errors(report.prices, spectral=True)
    on_spectral_front = {int(k) for k in pareto_front(*spectral)}
    on_front = front_of(report.prices)
    points = tuple(
        CostPoint(
            name=_folded(price.setting.name),
            group=price.setting.group,
            seconds=price.cpu_seconds,
            memory_bytes=price.memory_bytes,
            illuminance=(price.illuminance.rms, price.illuminance.p95, price.illuminance.largest),
            spectrum=(price.spectrum.rms, price.spectrum.p95, price.spectrum.largest),
            illuminance_hidden=price.illuminance.below_floor,
            spectrum_hidden=price.spectrum.below_floor,
            on_front=k in on_front,
            on_spectral_front=k in on_spectral_front,
            efforts=efforts_of(price.setting.options),
        )
        for k, price in enumerate(report.prices)
    )
    bands = tuple(
        BandsPoint(b.bands, b.cpu_seconds, abs(b.mean_illuminance), b.chromaticity, b.cct, b.ra, abs(b.melanopic))
        for b in report.bands
    )
    return CostPicture(report.scene, points, report.noise, report.spectral_noise, bands)


def _cells(price: Price) -> tuple[Any, ...]:
    """One row, in the order of `COLUMNS`."""
    lux, spectrum = price.illuminance, price.spectrum
    return (
        *(price.setting.name, price.setting.group, price.setting.flags, price.on_front),
        *(_short(price.cpu_seconds), _short(price.wall_seconds), price.memory_bytes, price.elements, price.seeds),
        *(_short(lux.rms), _short(lux.p95), _short(lux.largest), lux.below_floor),
        *(_short(spectrum.rms), _short(spectrum.p95), _short(spectrum.largest), spectrum.below_floor),
        *(_short(price.bias), _short(price.sampling)),
    )


def _short(value: float) -> float:
    """Five digits."""
    return float(f"{value:.5g}")


def _folded(name: str) -> str:
    """The name of a combination on several lines."""
    parts = name.split(", ")
    return ",\n".join(", ".join(parts[k : k + 2]) for k in range(0, len(parts), 2))
