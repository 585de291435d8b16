"""Pictures against what they must show."""

import json
from dataclasses import replace

import numpy as np
import pytest
from drawn import QUICK, camera, draw, furnace, furnished_room
from rooms import SceneBuilder

from hradiosity.errors import OutputError, SceneError
from hradiosity.metrics.colorimetric import xyz_weights
from hradiosity.metrics.photometric import luminous_weights
from hradiosity.model.scene import Sky
from hradiosity.options import Options
from hradiosity.radiosity import RadiositySolver, solve
from hradiosity.show.colormap import colours_of
from hradiosity.show.pictures import MODES, PictureOptions, write_pictures
from hradiosity.show.preview import Preview
from hradiosity.transport.refine import RefinementOptions

INSIDE = camera((0.2, 0.25, 0.6), (0.9, 0.8, 0.4), field_of_view=90)
ROOM = camera((0.3, 0.3, 1.7), (2.2, 3.2, 0.8), field_of_view=85)


@pytest.mark.parametrize("rho", [0.2, 0.8])
def test_furnace_is_a_constant_picture(device, rho):
    """M = M0 + rho E = M0 / (1 - rho) on all walls, corners and edges included."""
    scene = furnace(rho, 3.0)
    _, drawn = draw(device, scene, INSIDE, modes=("flat", "smooth"))
    expected = 3.0 / (1 - rho) / np.pi * xyz_weights(scene.bands)[0]
    for picture in drawn.values():
        for channel, value in zip("XYZ", expected):
            np.testing.assert_allclose(picture.channels[channel], value, rtol=1e-3)


def test_false_colours_of_the_furnace(device):
    """One illuminance, one colour; the scale's numbers are those that were asked for."""
    scene = furnace(0.5, 2.0)
    lux = 4.0 * luminous_weights(scene.bands)[0]
    high = 2.5 * lux
    drawn, pictures = draw(device, scene, INSIDE, modes=("false-color",), scale_range=(0.0, high))
    picture = pictures["v", "false-color"]
    np.testing.assert_allclose(picture.channels["illuminance"], lux, rtol=1e-3)
    colour = np.rint(255 * colours_of(np.array(lux / high)))
    assert np.abs(picture.pixels[:, :64].astype(int) - colour).max() <= 2
    assert drawn.record["false_color"] == {
        "quantity": "illuminance", "unit": "lx", "low": 0.0, "high": high, "logarithmic": False
    }  # fmt: skip
    assert picture.pixels.shape == (48, 64 + 96, 3) and picture.pixels[:, 64:].max() == 255


def test_false_colours_of_luminance(device):
    scene = furnace(0.5, 2.0)
    _, pictures = draw(device, scene, INSIDE, modes=("false-color",), quantity="luminance", logarithmic=True)
    expected = 4.0 / np.pi * luminous_weights(scene.bands)[0]
    np.testing.assert_allclose(pictures["v", "false-color"].channels["luminance"], expected, rtol=1e-3)


def test_lamp_shows_its_own_exitance_over_pi(device):
    """A black room: the lamp has L = M / pi, all else is black."""
    b = SceneBuilder()
    black = b.material(0.0)
    b.box((0, 0, 0), (1, 1, 1), black, inward=True)
    b.lamp(b.patch((0.2, 0.999, 0.2), (0.6, 0, 0), (0, 0, 0.6), black), 5.0)
    scene = b.scene()
    _, drawn = draw(device, scene, camera((0.5, 0.1, 0.5), (0.5, 1, 0.5), field_of_view=60))
    luminance = drawn["v", "smooth"].channels["Y"]
    expected = 5.0 / np.pi * xyz_weights(scene.bands)[0, 1]
    np.testing.assert_allclose(luminance[20:28, 28:36], expected, rtol=1e-5)
    assert (luminance[0] == 0).all() and (luminance <= expected * (1 + 1e-5)).all()


def test_camera_that_sees_nothing_lit_is_black_in_all_modes(device):
    """No cell is in view, so that no leaf is planted anywhere."""
    away = camera((-3.0, 0.5, 0.5), (-2.0, 0.5, 0.5))
    _, drawn = draw(device, furnace(), away, modes=MODES)
    assert len(drawn) == len(MODES)
    for mode in ("flat", "smooth"):
        assert not drawn["v", mode].channels["Y"].any()


def test_exposure_puts_a_luminance_at_white(device):
    """A grey furnace of half the luminance of white has the code of linear 0.5 in its luminance."""
    scene = furnace(0.5, 2.0)
    y = 4.0 / np.pi * xyz_weights(scene.bands)[0, 1]
    drawn, pictures = draw(device, scene, INSIDE, white_luminance=2 * y)
    coded = pictures["v", "smooth"].pixels.astype(float) / 255
    linear = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)
    # 500-505 nm is far outside of sRGB: red is clipped and says so
    assert linear[..., 0].max() == 0 and pictures["v", "smooth"].developed.out_of_gamut == 1.0
    assert np.ptp(linear) > 0 and drawn.record["exposure"]["white_luminance_cd_m2"] == 2 * y


def test_closed_room_has_no_black_pixel(device):
    """Watertight: no crack between patches, leaves or cells lets the black outside through."""
    view = replace(ROOM, width=320, height=240)
    _, drawn = draw(device, furnished_room(), view, modes=("flat", "smooth"))
    for picture in drawn.values():
        assert picture.channels["Y"].min() > 0 and picture.empty == 0 and picture.dark == 0


def test_sky_is_seen_above_the_horizon(device):
    b = SceneBuilder()
    b.patch((-1, -1, 0), (2, 0, 0), (0, 2, 0), b.material(0.5))
    b.sky = Sky(np.array([3.0]))
    scene = b.scene()
    _, drawn = draw(device, scene, camera((0, -3, 1), (0, 0, 0.8), field_of_view=90))
    luminance = drawn["v", "smooth"].channels["Y"]
    sky = 3.0 * xyz_weights(scene.bands)[0, 1]
    np.testing.assert_allclose(luminance[:8], sky, rtol=1e-6)
    np.testing.assert_allclose(np.median(luminance[luminance < 0.9 * sky][luminance[luminance < 0.9 * sky] > 0]),
                               0.5 * sky, rtol=0.01)  # fmt: skip


def test_no_dark_fringe_around_a_block(device):
    """Leaves that reach under a thin block are drawn from their vertices in the open, however large they are."""
    b = SceneBuilder()
    white = b.material(0.5)
    b.box((0, 0, 0), (2, 2, 2), white, inward=True)
    b.box((0.55, 0.61, 0), (1.47, 1.39, 0.02), white, solid=True)
    b.lamp(range(4, 6), 1.0)
    view = camera((1.0, 0.2, 1.5), (1.0, 1.0, 0.0), width=96, height=96)
    whole = RefinementOptions(base_level=0, max_level=0)
    pictures = draw(device, b.scene(), view, modes=("false-color",), scale_range=(0, 1e4), refinement=whole)[1]
    lux = pictures["v", "false-color"].channels["illuminance"][:, 48]
    print("darkest over median", lux.min() / np.median(lux))
    assert lux.min() > 0.8 * np.median(lux)


def test_files_are_the_same_bytes_every_time(device, tmp_path):
    scene = replace(furnished_room(), views=(ROOM,))
    solution = solve(scene, QUICK, device)
    options = PictureOptions(logarithmic=True)
    for name in ("a", "b"):
        write_pictures(solution, tmp_path / name, device, options)
    names = sorted(p.name for p in (tmp_path / "a").iterdir())
    expected = {f"v_{mode}.png" for mode in MODES} | {f"v_{m}.exr" for m in MODES if m != "wireframe"}
    assert set(names) == expected | {"pictures.json"}
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    record = json.loads((tmp_path / "a" / "pictures.json").read_text())
    assert [p["mode"] for p in record["pictures"]] == list(MODES)
    assert record["exposure"]["white_luminance_cd_m2"] > 0


def test_exr_holds_the_numbers(device, tmp_path):
    import OpenEXR

    scene = replace(furnace(0.5, 2.0), views=(INSIDE,))
    write_pictures(solve(scene, QUICK, device), tmp_path, device, PictureOptions(modes=("smooth",)))
    with OpenEXR.File(str(tmp_path / "v_smooth.exr"), separate_channels=True) as file:
        y = file.channels()["Y"].pixels
        assert "cd/m" in file.header()["units"]
    np.testing.assert_allclose(y, 4.0 / np.pi * xyz_weights(scene.bands)[0, 1], rtol=1e-3)


def test_scene_without_a_view_gets_one_and_says_so(device):
    drawn = draw(device, furnished_room())[0]
    assert "names no [[view]]" in drawn.notes[0].message and len(drawn.pictures) == 1
    assert drawn.pictures[0].dark < 0.05


def test_camera_in_a_solid_is_refused(device):
    with pytest.raises(SceneError, match="is inside"):
        draw(device, furnished_room(), camera((0.9, 1.0, 0.3), (2, 3, 0.8)))


def test_folder_that_cannot_be_written(device, tmp_path):
    (tmp_path / "file").write_text("")
    solution = solve(replace(furnace(), views=(INSIDE,)), QUICK, device)
    with pytest.raises(OutputError, match="can't be made"):
        write_pictures(solution, tmp_path / "file", device, PictureOptions(modes=("flat",)))


@pytest.mark.parametrize(
    "wrong",
    [{"modes": ()}, {"modes": ("nice",)}, {"white_luminance": 0.0}, {"scale_range": (2.0, 1.0)},
     {"scale_range": (0.0, 1.0), "logarithmic": True}],
)  # fmt: skip
def test_options_are_checked(wrong):
    with pytest.raises(ValueError):
        PictureOptions(**wrong)


def test_preview_of_even_light_is_even(device, tmp_path):
    """Flat elements of the furnace at the exposure of the first light: all of one colour."""
    scene = replace(furnace(0.5, 2.0), views=(INSIDE,))
    solver = RadiositySolver(scene, Options(replicates=2, gather_samples=8), device)
    preview = Preview(scene, device)
    for state in solver.states():
        if state.replicate:
            preview.write(solver, tmp_path / "preview.png")
    assert (tmp_path / "preview.png").read_bytes()[1:4] == b"PNG"
    light = preview.pixels(solver.solution())
    assert light.shape == (48, 64, 3)
    assert np.ptp(light.reshape(-1, 3), axis=0).max() <= 1


def test_preview_agrees_with_the_flat_picture(device):
    """Lamps included; the picture refines shadows, so that only means agree."""
    solution = solve(replace(furnished_room(), views=(ROOM,)), QUICK, device)
    preview = Preview(solution.scene, device)
    quick = preview.pixels(solution).astype(float).mean()
    white = preview.white_luminance
    _, drawn = draw(device, furnished_room(), ROOM, modes=("flat",), white_luminance=white)
    assert quick == pytest.approx(drawn["v", "flat"].pixels.mean(), rel=0.03)


@pytest.mark.parametrize(
    ("pictures", "lamp", "needed"), [(False, True, False), (True, True, True), (True, False, False)]
)
def test_plan_says_whether_shadows_are_refined(device, pictures, lamp, needed):
    room = SceneBuilder()
    room.box((0, 0, 0), (1, 1, 1), room.material(0.5), inward=True)
    if lamp:
        room.lamp(5, 1.0)
    plan = RadiositySolver(room.scene(), replace(QUICK, pictures=pictures), device).plan
    (effect,) = [e for e in plan.effects if e.name == "shadow refinement"]
    assert effect.needed == needed and effect.because
