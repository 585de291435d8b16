"""Spectra from text files: columns of wavelength [nm] and value."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from hradiosity.errors import Fault, SceneError
from hradiosity.model.photometry import unknown_name
from hradiosity.model.spectrum import Spectrum

Kind = Literal["reflectance", "power"]

MOST_FAULTS_A_KIND: Final = 10
"""A file that is wrong on every line shouldn't fill the screen."""

_EXPECTED_LINES: Final = "lines with a wavelength in nm and a value"

_DECIMAL_COMMA: Final = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")

_SPECTRAL_LINE: Final = re.compile(r"[\"']?line[\"']?(?:\s*[;,\t]\s*|\s+)", re.IGNORECASE)


_FIRST_NUMBER: Final = re.compile(r"[\"']?[+-]?\.?\d")


@dataclass(frozen=True)
class _Row:
    """The cells of one line of the file, and where it stands (counted from 1).

    ``is_line``: it began with the word ``line``, which is not among the cells.
    """

    line: int
    cells: tuple[str, ...]
    is_line: bool = False


@dataclass(frozen=True)
class _Table:
    """A file cut into cells; ``header`` is empty when the file has none."""

    header: tuple[str, ...]
    rows: tuple[_Row, ...]


def read_spectrum_csv(path: str | Path, column: str | None = None, kind: Kind = "reflectance") -> Spectrum:
    """Read a spectrum from columns of text.

    Cells are separated by semicolons, tabs, commas or blanks; ``#`` starts a comment; a header line is optional. The
    first column is the wavelength in nm. A row that begins with the word ``line``, as in ``line, 546.07, 12.3``, is a
    narrow spectral line: its wavelength in nm and its whole power, in the unit of the table times nm.

    Parameters
    ----------
    path : path of the file
        UTF-8, with or without byte order mark.
    column : str, optional
        Name in the header of the column to read; needed when there are more than two columns.
    kind : "reflectance" or "power"
        A reflectance must lie between 0 and 1 and has no lines; a power must not be negative.

    Returns
    -------
    Spectrum

    Raises
    ------
    SceneError
        With every fault found: each names the file, the line, what stands there and what was expected.
    """
    name = str(path)
    table = _cut(name, _text(Path(path)))
    index = _column_index(name, table, column)
    _check_cells(name, table, index)
    rows = [row for row in table.rows if not row.is_line]
    lines = [row for row in table.rows if row.is_line]
    numbers, line_numbers = _numbers(rows, index), _numbers(lines, index)
    faults = [*_wavelength_faults(name, numbers[:, 0], rows), *_value_faults(name, numbers[:, 1], rows, kind)]
    if len(rows) == 1:
        faults.append(Fault(name, f"line {rows[0].line}", "only one wavelength", "at least two are needed"))
    faults += _line_faults(name, line_numbers, lines, kind)
    if faults:
        raise SceneError(faults)
    return Spectrum(numbers[:, 0], numbers[:, 1], line_numbers[:, 0], line_numbers[:, 1])


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        found = f"can't be read ({error.strerror})"
        raise SceneError([Fault(str(path), "", found, "a text file with a spectrum")]) from error
    except UnicodeDecodeError as error:
        expected = "the table saved as plain UTF-8 text (CSV)"
        raise SceneError([Fault(str(path), "", "is not UTF-8 text", expected)]) from error


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _split(line: str, separator: str | None) -> tuple[str, ...]:
    cells = [cell.strip().strip("\"'").strip() for cell in line.split(separator)]
    while len(cells) > 1 and cells[-1] == "":
        cells.pop()
    return tuple(cells)


def _separator(line: str) -> str | None:
    """What cuts a line into cells; None stands for blanks."""
    if ";" in line:
        return ";"
    if "\t" in line:
        return "\t"
    with_blanks = line.split()
    if len(with_blanks) > 1 and all(_DECIMAL_COMMA.fullmatch(cell) or _is_number(cell) for cell in with_blanks):
        return None
    return "," if "," in line else None


def _mark(line: str, *, may_be_header: bool) -> tuple[str, bool]:
    """The line without a leading word ``line``, and whether there was one."""
    found = _SPECTRAL_LINE.match(line)
    if found is None or (may_be_header and not _FIRST_NUMBER.match(line, found.end())):
        return line, False
    return line[found.end() :], True


def _cut(name: str, text: str) -> _Table:
    """Find the header and cut all lines; the separator is the one of the first line that starts with a number."""
    lines = [(i, line.split("#", 1)[0].strip()) for i, line in enumerate(text.splitlines(), start=1)]
    lines = [(i, line) for i, line in lines if line]
    if not lines:
        raise SceneError([Fault(name, "", "is empty", _EXPECTED_LINES)])
    marked = [(i, *_mark(line, may_be_header=i == lines[0][0])) for i, line in lines]
    first_data = next((rest for _, rest, _ in marked if _FIRST_NUMBER.match(rest)), lines[0][1])
    separator = _separator(first_data)
    rows = tuple(_Row(i, _split(rest, separator), is_line) for i, rest, is_line in marked)
    first = rows[0].cells[0]
    if _is_number(first) or _DECIMAL_COMMA.fullmatch(first):
        return _Table((), rows)
    if len(rows) == 1:
        raise SceneError([Fault(name, f"line {rows[0].line}", "nothing but a header", _EXPECTED_LINES)])
    return _Table(rows[0].cells, rows[1:])


def _column_index(name: str, table: _Table, column: str | None) -> int:
    """Which cell of each row holds the value."""
    if column is None:
        n_columns = len(table.header or table.rows[0].cells)
        if n_columns == 2:
            return 1
        if n_columns < 2:
            found, expected = "only one column", "two columns: wavelength in nm and value"
        else:
            found, expected = f"{n_columns} columns", "two, or the name of the column to read" + _choices(table)
        raise SceneError([Fault(name, f"line {table.rows[0].line}", found, expected)])
    if column in table.header[1:]:
        return table.header.index(column, 1)
    if not table.header:
        found = f"has no header, so no column {column!r}"
        raise SceneError([Fault(name, "", found, "a first line that names the columns")])
    raise SceneError([Fault(name, "", unknown_name("column", column, table.header[1:]), "")])


def _choices(table: _Table) -> str:
    return f" ({', '.join(table.header[1:])})" if table.header else "; they need a header line for that"


def _check_cells(name: str, table: _Table, index: int) -> None:
    """Raise when a cell that is read is no number."""
    n_columns = len(table.header or table.rows[0].cells)
    faults = [_cell_fault(name, row, n_columns, index) for row in table.rows]
    if any(faults):
        raise SceneError(_shortened([fault for fault in faults if fault is not None]))


def _numbers(rows: list[_Row], index: int) -> NDArray[np.float64]:
    """(n, 2) wavelengths and values of rows that were checked."""
    return np.array([(float(row.cells[0]), float(row.cells[index])) for row in rows]).reshape(-1, 2)


def _cell_fault(name: str, row: _Row, n_columns: int, index: int) -> Fault | None:
    """What is wrong with one row's shape or numbers, if anything."""
    place = f"line {row.line}"
    if len(row.cells) != n_columns:
        hint = "; is the comma a decimal sign? write 0.5, not 0,5" if len(row.cells) > n_columns else ""
        return Fault(name, place, f"{len(row.cells)} columns", f"{n_columns}, as in the lines above{hint}")
    for where, cell in (("", row.cells[0]), (f" at {row.cells[0]} nm", row.cells[index])):
        if _DECIMAL_COMMA.fullmatch(cell):
            return Fault(name, place, f"{cell!r} has a decimal comma", f"a decimal point: {cell.replace(',', '.')}")
        if not _is_number(cell):
            return Fault(name, place, f"{cell!r}" if cell else "an empty cell", "a number")
        if not np.isfinite(float(cell)):
            return Fault(name, place, f"{cell!r}{where}", "a finite number")
    return None


def _shortened(faults: list[Fault]) -> list[Fault]:
    """The first faults of one kind, and how many more there are."""
    left = len(faults) - MOST_FAULTS_A_KIND
    if left <= 0:
        return faults
    return [*faults[:MOST_FAULTS_A_KIND], Fault(faults[0].file, "", f"{left} more lines like these", "")]


def _wavelength_faults(name: str, wavelength: NDArray[np.float64], rows: list[_Row]) -> list[Fault]:
    """Wrong unit, wrong order, duplicates."""
    faults = _unit_faults(name, wavelength, rows)
    for i in np.flatnonzero(np.diff(wavelength) <= 0) if not faults else ():
        now, before = wavelength[i + 1], wavelength[i]
        found = f"wavelength {now:g} twice" if now == before else f"wavelength {now:g} after {before:g}"
        faults.append(Fault(name, f"line {rows[i + 1].line}", found, "wavelengths that ascend, each once"))
    return _shortened(faults)


def _unit_faults(name: str, wavelength: NDArray[np.float64], rows: list[_Row]) -> list[Fault]:
    """Wavelengths that are not in nm."""
    if not len(wavelength):
        return []
    span = f"wavelengths {wavelength.min():g}–{wavelength.max():g}"
    if wavelength.min() <= 0:
        worst = int(wavelength.argmin())
        return [Fault(name, f"line {rows[worst].line}", f"wavelength {wavelength[worst]:g}", "above 0 nm")]
    if wavelength.max() < 1e-3:
        return [Fault(name, "", f"{span} look like metres", "nm: multiply by 1e9")]
    if wavelength.max() < 30:
        return [Fault(name, "", f"{span} look like µm", "nm: multiply by 1000")]
    return []


def _value_faults(name: str, value: NDArray[np.float64], rows: list[_Row], kind: Kind) -> list[Fault]:
    """Negative values; a reflectance above 1."""
    negative = np.flatnonzero(value < 0)
    faults = _shortened([Fault(name, f"line {rows[i].line}", f"{kind} {value[i]:g}", "0 or more") for i in negative])
    if kind == "reflectance" and value.max(initial=0.0) > 1:
        highest = int(value.argmax())
        expected = "0 to 1" + ("; it looks like percent: if so, divide by 100" if value.max() <= 100 else "")
        faults.append(Fault(name, f"line {rows[highest].line}", f"reflectance {value[highest]:g}", expected))
    return faults


def _line_faults(name: str, numbers: NDArray[np.float64], lines: list[_Row], kind: Kind) -> list[Fault]:
    """Spectral lines of a reflectance, in a wrong unit, or with negative power."""
    if lines and kind == "reflectance":
        found = f"a spectral line at {numbers[0, 0]:g} nm"
        return [Fault(name, f"line {lines[0].line}", found, "no lines: a reflectance has a value at each wavelength")]
    return [*_unit_faults(name, numbers[:, 0], lines), *_value_faults(name, numbers[:, 1], lines, kind)]
