from pathlib import Path

import numpy as np
import pytest

from hradiosity.errors import SceneError
from hradiosity.io.spectra import read_spectrum_csv

SPECTRA = Path(__file__).parents[2] / "scenes" / "cornell_box" / "spectra"


@pytest.fixture
def write(tmp_path):
    def make(text, encoding="utf-8"):
        path = tmp_path / "paint.csv"
        path.write_bytes(text if isinstance(text, bytes) else text.encode(encoding))
        return path

    return make


@pytest.mark.parametrize(
    "text",
    [
        "400,0.1\n500,0.2\n",
        "wavelength_nm,value\n400,0.1\n500,0.2",
        "# measured\r\n\r\nnm;rho\r\n400;0.1\r\n500;0.2 # here\r\n",
        "nm\trho\n400\t0.1\n500\t2e-1\n",
        "400   0.1\n500 .2\n",
        "\ufeffwavelength (nm),reflectance factor\n400,0.1\n500,0.2\n",
        '"nm","rho"\n"400","0.1"\n"500","0.2"\n',
        "400,0.1,\n500,0.2,\n",
    ],
)
def test_all_usual_ways_of_writing_a_table(write, text):
    spectrum = read_spectrum_csv(write(text))
    np.testing.assert_array_equal(spectrum.wavelength, [400, 500])
    np.testing.assert_array_equal(spectrum.value, [0.1, 0.2])


def test_a_column_is_chosen_by_its_name(write):
    path = write("nm,red,blue\n400,0.1,0.7\n500,0.2,0.6\n")
    np.testing.assert_array_equal(read_spectrum_csv(path, column="blue").value, [0.7, 0.6])
    with pytest.raises(SceneError, match=r"3 columns.*red, blue"):
        read_spectrum_csv(path)
    with pytest.raises(SceneError, match="did you mean blue"):
        read_spectrum_csv(path, column="bleu")
    with pytest.raises(SceneError, match="no header"):
        read_spectrum_csv(write("400,0.1,0.2\n500,0.1,0.2"), column="red")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("# only a comment\n\n", "is empty"),
        ("nm,rho\n", "nothing but a header"),
        ("400,0.1\n", "line 1: only one wavelength"),
        ("400\n500\n", "line 1: only one column"),
        ("400,0.1\n390,0.2\n", "line 2: wavelength 390 after 400"),
        ("400,0.1\n400,0.2\n", "line 2: wavelength 400 twice"),
        ("400,0.1\n500,nan\n", "line 2: 'nan' at 500 nm; a finite number"),
        ("nm,rho\n400,0.1\n500,abc\n", "line 3: 'abc'; a number"),
        ("400,0.1\n500,\n600,0.2\n", "line 2: 1 columns"),
        ("400,,0.1\n500,0.2,0.3\n", "3 columns"),
        ("0.38,0.1\n0.78,0.2\n", "0.38–0.78 look like µm; nm"),
        ("380e-9,0.1\n780e-9,0.2\n", "look like metres; nm"),
        ("-400,0.1\n500,0.2\n", "line 1: wavelength -400"),
        ("400,10\n500,85\n", "line 2: reflectance 85.*percent"),
        ("400,0.1\n500,300\n", "line 2: reflectance 300; 0 to 1$"),
        ("400,-0.1\n500,0.2\n", "line 1: reflectance -0.1; 0 or more"),
        ("400;0,1\n500;0,2\n", "line 1: '0,1' has a decimal comma; a decimal point: 0.1"),
        ("400 0,1\n500 0,2\n", "decimal comma"),
        ("400,0;0,1\n500,0;0,2\n", "decimal comma"),
        ("nm,rho\n400,0,1\n500,0,2\n", "line 2: 3 columns; 2.*decimal sign"),
        (b"\xff\xfe4\x000\x00", "not UTF-8"),
    ],
)
def test_every_fault_is_named_with_its_line(write, text, message):
    with pytest.raises(SceneError, match=message) as caught:
        read_spectrum_csv(write(text))
    assert all(fault.file.endswith("paint.csv") for fault in caught.value.faults)


def test_all_faults_come_at_once_but_not_hundreds(write):
    with pytest.raises(SceneError) as caught:
        read_spectrum_csv(write("400,0.1\n390,-0.2\n500,2\n500,0.1"))
    assert [fault.entry for fault in caught.value.faults] == ["line 2", "line 4", "line 2", "line 3"]
    with pytest.raises(SceneError, match="490 more lines") as caught:
        read_spectrum_csv(write("\n".join(f"{w},x" for w in range(400, 900))))
    assert len(caught.value.faults) == 11


def test_a_power_may_exceed_one_but_not_be_negative(write):
    assert read_spectrum_csv(write("400,10\n500,85\n"), kind="power").value.max() == 85
    with pytest.raises(SceneError, match="power -1"):
        read_spectrum_csv(write("400,10\n500,-1\n"), kind="power")


@pytest.mark.parametrize(
    "text",
    [
        "nm,power\n400,1\nline, 546.07, 12.3\n500,2\nline,435.83,4\n",
        "400;1\n500;2\nLine;546.07;12.3 # green\nline;435.83;4\n",
        "line 546.07 12.3\n400 1\n500 2\nline 435.83 4\n",
        '"nm"\t"mW"\n"line"\t"546.07"\t"12.3"\nline\t435.83\t4\n400\t1\n500\t2',
    ],
)
def test_spectral_lines_stand_among_the_rows_of_a_power(write, text):
    spectrum = read_spectrum_csv(write(text), kind="power")
    np.testing.assert_array_equal(spectrum.wavelength, [400, 500])
    np.testing.assert_array_equal(spectrum.value, [1, 2])
    assert dict(zip(spectrum.line_wavelength, spectrum.line_power)) == {546.07: 12.3, 435.83: 4}


def test_a_file_may_hold_lines_only_and_several_columns(write):
    text = "line,one,two\nline,546.07,3,5\nline,435.83,4,6\n"
    spectrum = read_spectrum_csv(write(text), "two", "power")
    assert len(spectrum.wavelength) == 0
    np.testing.assert_array_equal(spectrum.line_power, [5, 6])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("400,1\n500,2\nline,546.07,-3\n", "line 3: power -3"),
        ("400,1\n500,2\nline,0.54607,3\n", "look like µm"),
        ("400,1\n500,2\nline,546.07\n", "line 3: 1 columns; 2, as in the lines above"),
        ("400,1\n500,2\nline,green,2\n", "line 3: 'green'; a number"),
        ("400,1\n500,2\nline,546,07,12\n", "is the comma a decimal sign"),
        ("400,1\nline,546.07,3\n", "line 1: only one wavelength"),
    ],
)
def test_faults_in_spectral_lines_are_named(write, text, message):
    with pytest.raises(SceneError, match=message):
        read_spectrum_csv(write(text), kind="power")


def test_a_reflectance_has_no_lines(write):
    with pytest.raises(SceneError, match=r"line 3: a spectral line at 546\.07 nm"):
        read_spectrum_csv(write("400,0.1\n500,0.2\nline,546.07,0.3\n"))


def test_a_missing_file_is_a_fault(tmp_path):
    with pytest.raises(SceneError, match="can't be read"):
        read_spectrum_csv(tmp_path / "none.csv")


def test_the_cornell_box_spectra_are_the_measured_ones():
    for name, first, last in (("white", 0.343, 0.737), ("red", 0.04, 0.642), ("green", 0.092, 0.159)):
        spectrum = read_spectrum_csv(SPECTRA / f"{name}.csv")
        assert len(spectrum.wavelength) == 76
        assert (spectrum.value[0], spectrum.value[-1]) == (first, last)
    np.testing.assert_array_equal(read_spectrum_csv(SPECTRA / "light_spd.csv", kind="power").value, [0, 8, 15.6, 18.4])
