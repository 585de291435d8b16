"""The program starts fast and helps."""

import json
import subprocess
import sys
import time

import pytest

HEAVY = ("numpy", "scipy", "pyopencl", "pyvista", "vtk", "h5py", "pydantic", "pymeshlab", "colour")


def python(*arguments):
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, timeout=120)


def test_help_is_quick_and_loads_nothing_heavy():
    code = (
        "import sys, time; start = time.process_time()\n"
        "from hradiosity.cli import main\n"
        "try:\n    main(['--help'])\nexcept SystemExit:\n    pass\n"
        f"print('HEAVY', [name for name in {HEAVY!r} if name in sys.modules])\n"
        "print('SECONDS', time.process_time() - start)\n"
    )
    start = time.perf_counter()
    done = python("-c", code)
    wall = time.perf_counter() - start
    seconds = float(done.stdout.split("SECONDS")[1])
    print(f"--help: {seconds:.2f} s of CPU, {wall:.2f} s wall with the interpreter")
    assert "HEAVY []" in done.stdout
    assert seconds < 0.5


def test_importing_the_package_loads_nothing_heavy():
    done = python("-c", f"import sys, hradiosity; print([name for name in {HEAVY!r} if name in sys.modules])")
    assert done.stdout.strip() == "[]"


def test_the_first_picture_waits_for_no_solver_library():
    """A run reads its scene and draws its first picture with what this loads."""
    modules = "hradiosity.cli.session, hradiosity.show.first_picture"
    done = python("-c", f"import sys, {modules}; print([n for n in {HEAVY!r} if n in sys.modules])")
    assert done.stdout.strip() == "['numpy', 'pydantic']"


def test_the_first_picture_waits_for_no_part_of_the_solver():
    """What only a solution needs is loaded once the picture is there."""
    late = ("radiosity", "readings", "solvers", "planning", "solution", "transport.exchange", "io.results", "suites")
    code = f"import sys, hradiosity.cli.session; print([n for n in {late!r} if 'hradiosity.' + n in sys.modules])"
    assert python("-c", code).stdout.strip() == "[]"


def test_every_verb_has_help(call):
    for verb in ("render", "plan", "devices", "schema", "new"):
        shown = call(verb, "--help")
        assert shown.code == 0
        assert "Usage: hradiosity" in shown.out


def test_version_as_a_module():
    done = python("-m", "hradiosity", "--version")
    assert done.stdout.startswith("hradiosity ")
    assert done.returncode == 0


@pytest.mark.parametrize("name", ["load_scene", "solve", "Options", "Solution", "SceneError", "Device", "__version__"])
def test_public_names(name):
    import hradiosity

    assert getattr(hradiosity, name)
    assert name in dir(hradiosity)


def test_solve_is_the_function_whatever_was_imported():
    import hradiosity
    import hradiosity.solvers.krylov
    from hradiosity.solvers.krylov import solve_irradiance

    assert callable(solve_irradiance)
    assert hradiosity.solve.__name__ == "solve"
    assert callable(hradiosity.solve)


def test_other_names_are_refused():
    import hradiosity

    with pytest.raises(AttributeError, match="no attribute 'radiate'"):
        _ = hradiosity.radiate


def test_devices_marks_one(call):
    shown = call("devices")
    assert shown.code == 0
    assert sum(line.startswith("* ") for line in shown.out.splitlines()) == 2  # the device and the legend
    assert "gave the right numbers" in shown.out


def test_schema_is_json_schema(call):
    schema = json.loads(call("schema").out)
    assert "materials" in schema["properties"]


def test_new_room_can_be_planned(call, tmp_path):
    folder = tmp_path / "my room"
    made = call("new", "room", folder)
    assert made.code == 0
    assert str(folder / "scene.toml") in made.out
    planned = call("plan", folder)
    assert planned.code == 0
    assert "interreflection computed" in " ".join(planned.out.split())
    assert call("new", "room", folder).code == 2


def test_plan_says_what_is_left_out(call, room):
    text = (room / "scene.toml").read_text().replace("[[380, 560, 0.3], [560, 740, 0.6]]", "[[380, 740, 0.0]]")
    (room / "scene.toml").write_text(text.replace("reflectance = 0.2", "reflectance = 0.0"))
    shown = call("plan", room)
    assert "interreflection left out nothing reflects" in " ".join(shown.out.split())
    assert json.loads(call("plan", room, "--json").out)["interreflection"] is False
