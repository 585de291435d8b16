"""Images as files, read back by other programs."""

import json
from dataclasses import replace

import numpy as np
import pytest
from drawn import QUICK, camera, furnace, furnished_room

from hradiosity.errors import OutputError
from hradiosity.metrics.colorimetric import xyz_weights
from hradiosity.radiosity import solve
from hradiosity.show import image as image_module
from hradiosity.show import image_pictures
from hradiosity.show.image_pictures import ImageOptions, time_left, write_images
from hradiosity.show.pictures import PictureOptions
from hradiosity.show.radiance_file import radiance_picture, scan_line

INSIDE = camera((0.2, 0.25, 0.6), (0.9, 0.8, 0.4), field_of_view=90)
ROOM = camera((0.3, 0.3, 1.7), (2.2, 3.2, 0.8), field_of_view=85)


def read_radiance(path):
    """(height, width, 3) float32 by VTK, which can not read very small files."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOImage import vtkHDRReader

    reader = vtkHDRReader()
    reader.SetFileName(str(path))
    reader.Update()
    image = reader.GetOutput()
    width, height, _ = image.GetDimensions()
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, 3)[::-1]


def read_exr(path):
    import OpenEXR

    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels for name, channel in file.channels().items()}, dict(file.header())


@pytest.mark.parametrize("width", [7, 8, 300])
def test_radiance_picture_as_vtk_reads_it(tmp_path, width):
    """Luminance 179 (0.265 R + 0.670 G + 0.065 B), within a mantissa's step, over twelve decades and long runs."""
    random = np.random.default_rng(1)
    xyz = np.full((50, width, 3), [0.9, 1.0, 0.9]) * 10 ** random.uniform(-6, 6, (50, width, 1))
    xyz[1] = [95.0, 100.0, 90.0]
    xyz[2, ::3] = 0.0
    (tmp_path / "a.hdr").write_bytes(radiance_picture(xyz, {"VIEWNAME": "a"}))
    rgb = read_radiance(tmp_path / "a.hdr").astype(float)
    assert rgb.shape == xyz.shape
    luminance = 179.0 * (0.265 * rgb[..., 0] + 0.670 * rgb[..., 1] + 0.065 * rgb[..., 2])
    np.testing.assert_allclose(luminance, xyz[..., 1], rtol=0.012)


def test_runs_are_short():
    row = np.tile(np.array([[7, 7, 7, 130]], np.uint8), (1000, 1))
    assert len(scan_line(row)) == 4 + 4 * 2 * 8


def test_files_of_an_image(device, tmp_path):
    scene = replace(furnace(0.5, 2.0), views=(INSIDE,))
    solution = solve(scene, QUICK, device)
    drawn, interrupted = write_images(solution, tmp_path, device, None, ImageOptions(samples=4, spectra=True))
    assert not interrupted
    names = {
        "v_image.png",
        "v_image.exr",
        "v_image.hdr",
        "v_image_false-color.png",
        "v_image_spectral.exr",
        "pictures.json",
    }
    assert {path.name for path in tmp_path.iterdir()} == names
    y = 4.0 / np.pi * xyz_weights(scene.bands)[0, 1]
    channels, header = read_exr(tmp_path / "v_image.exr")
    np.testing.assert_allclose(channels["Y"], y, rtol=2e-3)
    assert channels["SE.Y"].max() < 1e-3 * y and "cd/m" in header["units"]
    spectral, header = read_exr(tmp_path / "v_image_spectral.exr")
    np.testing.assert_allclose(spectral["S0.502,5nm"], 4.0 / np.pi / 5.0, rtol=2e-3)
    assert header["spectralLayoutVersion"] == "1.0" and header["emissiveUnits"] == "W.m^-2.sr^-1.nm^-1"
    record = json.loads((tmp_path / "pictures.json").read_text())
    assert record == drawn.record
    entry = record["pictures"][0]
    assert entry["kind"] == "image" and entry["complete"] and entry["noise_95"] < 1e-3 and entry["samples"] == 4
    # 500-505 nm is far outside of sRGB
    assert entry["out_of_gamut_share"] == 1.0 and entry["delta_e_2000_to_display_mean"] > 10
    assert record["false_color"]["quantity"] == "illuminance"


def test_spectra_make_the_colours_of_the_image(device, tmp_path):
    scene = replace(furnished_room(), views=(ROOM,))
    write_images(
        solve(scene, QUICK, device), tmp_path, device, None, ImageOptions(samples=4, spectra=True, size=(40, 30))
    )
    colours, _ = read_exr(tmp_path / "v_image.exr")
    spectral, _ = read_exr(tmp_path / "v_image_spectral.exr")
    bands = np.stack([spectral[f"S0.{f'{centre:g}'.replace('.', ',')}nm"] for centre in scene.bands.centre], axis=-1)
    assert bands.shape == (30, 40, 3)
    xyz = np.einsum("hwb,bc->hwc", bands * scene.bands.width, xyz_weights(scene.bands))
    for c, name in enumerate("XYZ"):
        np.testing.assert_allclose(xyz[..., c], colours[name], rtol=1e-4, atol=1e-4)


def test_the_display_shows_what_it_can(device, tmp_path):
    """White of twice the brightest luminance: nothing is clipped, and the grey room's colours are the display's."""
    scene = replace(furnished_room(), views=(ROOM,))
    solution = solve(scene, QUICK, device)
    drawn, _ = write_images(solution, tmp_path, device, PictureOptions(white_luminance=1e9), ImageOptions(samples=4))
    entry = drawn.record["pictures"][0]
    assert drawn.record["exposure"]["rule"] == "as asked for" and entry["overexposed_share"] == 0.0


def test_an_interrupted_image_is_kept_with_what_it_has(device, tmp_path, monkeypatch):
    scene = replace(furnished_room(), views=(ROOM, replace(ROOM, name="w")))
    solution = solve(scene, QUICK, device)
    passes = []

    def interrupting(*arguments, original=image_module.trace_pass):
        passes.append(1)
        if len(passes) == 3:
            raise KeyboardInterrupt
        return original(*arguments)

    monkeypatch.setattr(image_module, "trace_pass", interrupting)
    drawn, interrupted = write_images(solution, tmp_path, device, None, ImageOptions(samples=4))
    assert interrupted and [entry["view"] for entry in drawn.record["pictures"]] == ["v"]
    assert not drawn.record["pictures"][0]["complete"] and drawn.record["pictures"][0]["samples"] == 2


def test_the_time_left_is_told_at_the_pace_of_the_last_pass(device, tmp_path, monkeypatch):
    """Passes of 2 s for the first view and of 4 s for the second, which has twice the pixels."""
    scene = replace(furnished_room(), views=(ROOM, replace(ROOM, name="w", width=2 * ROOM.width)))
    solution = solve(scene, QUICK, device)
    clock = [0.0]

    def lasting(light, view, *others, original=image_module.trace_pass):
        clock[0] += 2.0 * view.width / ROOM.width
        return original(light, view, *others)

    monkeypatch.setattr(image_module, "trace_pass", lasting)
    monkeypatch.setattr(image_pictures, "perf_counter", lambda: clock[0])
    told = []
    write_images(solution, tmp_path, device, None, ImageOptions(samples=4), progress=told.append)
    expected = [f"image of 'v': pass {n} of 4{left}" for n, left in enumerate(
        ("", ", about 22 s left", ", about 20 s left", ", about 18 s left"), 1)]  # fmt: skip
    assert told[:4] == expected
    assert [words.rpartition("about ")[2] for words in told[4:]] == [f"{s} s left" for s in (16, 12, 8, 4)]


def test_long_times_are_told_in_minutes():
    assert time_left(0.0) == "" and time_left(99.0) == ", about 99 s left" and time_left(290.0) == ", about 5 min left"


def test_folder_that_cannot_be_written(device, tmp_path):
    (tmp_path / "file").write_text("")
    solution = solve(replace(furnace(), views=(INSIDE,)), QUICK, device)
    with pytest.raises(OutputError, match="can't be made"):
        write_images(solution, tmp_path / "file", device, None, ImageOptions(samples=1, size=(8, 8)))


@pytest.mark.parametrize("wrong", [{"samples": 0}, {"size": (0, 5)}, {"size": (5, 1 << 16)}])
def test_options_are_checked(wrong):
    with pytest.raises(ValueError):
        ImageOptions(**wrong)
