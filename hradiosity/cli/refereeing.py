"""``--referee N``: unbiased paths after the solution, and how far the two are apart."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from hradiosity.cli.display import Display
from hradiosity.cli.text import count, percent
from hradiosity.estimate import student_quantile
from hradiosity.io.output_folder import write_file
from hradiosity.io.results_tables import luminances, luminances_table, readings_table, spectra_table
from hradiosity.model.spectrum import Bands
from hradiosity.radiosity.referee import Referee, RefereeState
from hradiosity.readings.paths import SCRAMBLES
from hradiosity.solution import Readings
from hradiosity.suites.compare import Comparison, compare


def trace_referee(referee: Referee, display: Display) -> tuple[RefereeState | None, bool]:
    """Trace all rounds; returns the last state, None before the first round ended, and whether it was interrupted."""
    state = None
    try:
        for state in referee.states():
            paths = f"{count(state.paths)} of {count(state.wanted)} paths from each reading"
            display.stage(f"referee: {paths}, error {percent(state.error)} largest, {state.seconds:.1f} s")
    except KeyboardInterrupt:
        return state, True
    return state, False


def comparison(readings: Mapping[str, Readings], reference: Mapping[str, Readings]) -> Comparison | None:
    """How far the readings are from the referee's; None when there is no light to compare."""
    if not any(found.illuminance.any() for found in reference.values()):
        return None
    return compare(readings, reference, quantile=student_quantile(0.95, SCRAMBLES - 1))


def comparison_lines(found: Comparison) -> list[str]:
    """The comparison in words."""
    return [
        f"spectra      {percent(found.spectral_rms)} rms; the referee's own standard error is "
        f"{percent(found.reference_spectral_rms)}",
        f"illuminance  {percent(found.illuminance_rms)} rms, {percent(found.illuminance_max)} largest, "
        f"{percent(abs(found.bias))} too {'high' if found.bias > 0 else 'low'} on average; "
        f"the referee's own is {percent(found.reference_illuminance_rms)}",
        f"intervals    {percent(found.covered)} of {found.readings} hold the referee's illuminance",
    ]


def write_referee(folder: Path, readings: Mapping[str, Readings], bands: Bands) -> None:
    """The referee's tables beside those of the solution.

    Raises
    ------
    OutputError
        When a file can't be written.
    """
    write_file(folder / "referee_readings.csv", readings_table(readings, bands))
    if luminances(readings):
        write_file(folder / "referee_luminances.csv", luminances_table(readings, bands))
    write_file(folder / "referee_spectra.csv", spectra_table(readings, bands))
    write_file(folder / "referee_spectra_half_width.csv", spectra_table(readings, bands, half_width=True))
