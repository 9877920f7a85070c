"""Curves, pictures, comparisons and animations, of simulations and of folders."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from PIL import Image

import sphsolid as sph
from sphsolid.errors import InputError
from sphsolid.look.columns import chosen, families, shortened
from sphsolid.look.side import side_of
from sphsolid.look.view import angled_view, flat_view
from sphsolid.record import History, read_history
from sphsolid.record.stored import frame_files, read_frame

ROOT = Path(__file__).resolve().parents[3]


def size_of(png: bytes) -> tuple[int, int]:
    with Image.open(io.BytesIO(png)) as image:
        assert len(image.getcolors(10**6) or range(999)) > 20
        return image.size


# ---------------------------------------------------------------------- histories
def history() -> History:
    t = np.linspace(0.0, 1.0, 5)
    columns = {"time [s]": t, "step": np.arange(5), "tip_u_x [m]": t, "tip_u_y [m]": -t,
               "kinetic_energy [J]": t**2, "steps of what [-]": t}  # fmt: skip
    return History(pd.DataFrame(columns))


def test_a_history_has_a_panel_for_each_unit_with_it_on_the_axis():
    figure = history().plot()
    axes = [ax for ax in figure.axes if ax.lines]
    assert [ax.get_ylabel() for ax in axes] == ["tip u [m]", "kinetic energy [J]",
                                                "steps of what [-]"]  # fmt: skip
    assert {ax.get_xlabel() for ax in axes} == {"time [s]"}
    assert [text.get_text() for text in axes[0].get_legend().get_texts()] == ["x", "y"]
    assert size_of(figure._repr_png_())[0] > 400


def test_a_column_is_named_by_how_it_begins():
    lines = [line for ax in history().plot("tip").axes for line in ax.lines]
    assert len(lines) == 2
    [ax] = history().plot("tip_u_x", against="kinetic_energy").axes
    np.testing.assert_array_equal(ax.lines[0].get_xdata(), history()["kinetic_energy [J]"])


def test_a_column_that_is_not_there_is_refused_with_the_nearest():
    with pytest.raises(InputError, match=r"'tp_u_x \[m\]'; did you mean 'tip_u_x \[m\]'"):
        history().plot("tp_u_x [m]")
    with pytest.raises(InputError, match="no column 'energy'"):
        history()["energy"]
    with pytest.raises(InputError, match="has no rows"):
        History.of([]).plot()
    with pytest.raises(InputError, match="nothing but times"):
        History(history().table[["time [s]", "step"]]).plot()


def test_names_of_columns():
    assert shortened(["a_u_x", "a_u_y"]) == ("a_u", ["x", "y"])
    assert shortened(["kinetic_energy", "total_energy"]) == ("energy", ["kinetic", "total"])
    assert shortened(["a", "b"]) == ("", ["a", "b"])
    assert shortened(["a_b"]) == ("a_b", [""])
    assert families(["a [m]", "b [J]", "c [m]"]) == [("m", ["a [m]", "c [m]"]), ("J", ["b [J]"])]
    assert chosen([], ["time [s]", "step", "a"]) == ["a"]


def test_a_history_shows_itself_as_a_table():
    assert "<table" in history()._repr_html_()


# ---------------------------------------------------------------------- pictures
@pytest.mark.parametrize("method", ["sph", "fem"])
@pytest.mark.parametrize("field", ["pressure", "von_mises", "J", "u", "v_x", "cauchy_xy", "F_zz"])
def test_a_picture_of_either_method(method, field, ran, tmp_path):
    path = tmp_path / "p.png"
    figure = ran[method].simulation.snapshot().picture(field, path=path)
    assert size_of(path.read_bytes())[0] > 200
    assert len(figure.axes) > 1


def test_a_snapshot_shows_itself(ran):
    assert size_of(ran["sph"].simulation.snapshot()._repr_png_())[0] > 200


def test_values_are_those_of_the_field(ran):
    from sphsolid.look.scalars import values_at_vertices

    snapshot = ran["sph"].simulation.snapshot()
    found = {name: values_at_vertices(snapshot, name) for name in ("u", "p_y", "P_xz")}
    np.testing.assert_array_equal(found["u"], np.linalg.norm(snapshot.displacement, axis=1))
    np.testing.assert_array_equal(found["p_y"], snapshot.momentum[:, 1])
    np.testing.assert_array_equal(found["P_xz"], snapshot.P[:, 0, 2])


def test_what_is_no_field_is_refused(ran):
    snapshot = ran["sph"].simulation.snapshot()
    with pytest.raises(InputError, match=r"'presure'; did you mean 'pressure'\?"):
        snapshot.picture("presure")
    with pytest.raises(InputError, match="limits = 3 are not two numbers"):
        snapshot.picture(limits=3)
    with pytest.raises(InputError, match="axis 'w'"):
        snapshot.picture(up="w")


def test_the_side_that_a_body_is_seen_from():
    box = np.array([[0.0, 0, 0], [1, 1, 1]])
    assert side_of(box) == angled_view(up="z")
    assert side_of(box * [1, 6, 1]) == angled_view(up="y")
    assert side_of(box * [1, 1, 0.05]) == flat_view(right="x", up="y")
    assert side_of(box, up="x") == angled_view(up="x")


# ---------------------------------------------------------------------- folders
@pytest.mark.parametrize("method", ["sph", "fem"])
def test_a_frame_is_read_back_as_it_was(method, ran):
    snapshot = ran[method].simulation.snapshot()
    times = [time for time, _ in frame_files(ran[method].folder)]
    assert times == read_history(ran[method].folder / "history.csv")["time [s]"].tolist()
    found = read_frame(frame_files(ran[method].folder)[-1][1])
    assert (found.time, found.step) == (snapshot.time, snapshot.step)
    np.testing.assert_array_equal(found.x, snapshot.x)
    np.testing.assert_array_equal(found.X, snapshot.X)
    np.testing.assert_array_equal(found.mesh.cells, snapshot.mesh.cells)
    assert found.V.sum() == pytest.approx(snapshot.V.sum())
    for name in ("u", "pressure", "cauchy", "F"):
        wanted = snapshot.field(name).values.astype(np.float32)
        np.testing.assert_array_equal(found.field(name).values, wanted)
    assert found.mesh.boundary.shape == snapshot.mesh.boundary.shape
    with pytest.raises(InputError, match="no field 'q'"):
        found.field("q")


def test_a_folder_without_frames_is_refused(tmp_path):
    with pytest.raises(InputError, match="no frames to look at"):
        sph.animate(tmp_path)
    with pytest.raises(InputError, match="there is no folder"):
        sph.animate(tmp_path / "none")
    (tmp_path / "x.vtu").write_text("<VTKFile/>")
    with pytest.raises(InputError, match="no frame of a run, or is damaged"):
        read_frame(tmp_path / "x.vtu")


def test_an_animation_has_all_frames(ran, tmp_path):
    made = sph.animate(ran["sph"].folder, path=tmp_path / "a.gif", field="v")
    with Image.open(made) as image:
        assert image.n_frames == made.pictures == 4
    assert made._repr_html_().startswith('<img src="data:image/gif;base64,')
    with pytest.raises(InputError, match=r"does not end in \.gif"):
        sph.animate(ran["sph"].folder, path=tmp_path / "a.mp4")


# ---------------------------------------------------------------------- comparisons
def test_two_methods_beside_each_other(ran, tmp_path):
    a, b = ran["sph"].simulation, ran["fem"].simulation
    found = sph.compare(a, b, field="von_mises", labels=["particles", "elements"])
    table = found.table
    energy = "total_energy [J], at the end"
    ends = [run.history["total_energy [J]"][-1] for run in (a, b)]
    assert table.loc[energy, "particles"] == ends[0]
    assert table.loc[energy, "elements - particles"] == ends[1] - ends[0]
    largest = np.linalg.norm(a.snapshot().displacement, axis=1).max()
    assert table.loc["largest displacement [m]", "particles"] == largest
    found.save(tmp_path / "out")
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == [
        "bodies.png", "histories.png", "table.csv",
    ]  # fmt: skip
    html = found._repr_html_()
    assert html.count("<img") == 2
    assert "<table" in html
    assert "elements - particles" in str(found)


def test_the_difference_over_time_is_at_the_same_records(ran):
    a = ran["sph"]
    table = sph.compare(a.simulation, a.folder, a.folder).table
    over_time = table.filter(like="largest over time").dropna()
    assert len(over_time) == 4
    assert (over_time == 0.0).all(axis=None)


def test_folders_and_snapshots_are_compared_alike(ran):
    found = sph.compare(ran["sph"].folder, ran["fem"].folder, ran["sph"].simulation.snapshot())
    assert found.histories is None
    assert len(found.bodies.axes) > 3


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ((), "0 runs were given"), ((3, 4), "3 is no run"),
        ((History.of([]), History.of([])), "a history has no body"),
    ],
)  # fmt: skip
def test_what_cannot_be_compared_is_refused(given, message):
    with pytest.raises(InputError, match=message):
        sph.compare(*given)


# ---------------------------------------------------------------------- what is not installed
def python(text: str, folder: Path, **environment: str) -> str:
    """What a fresh Python prints that has neither a display nor a home."""
    clean = {k: v for k, v in os.environ.items() if k not in ("HOME", "DISPLAY", "MPLBACKEND")}
    done = subprocess.run(
        [sys.executable, "-c", text], cwd=folder, capture_output=True, text=True, timeout=300,
        env=clean | {"PYTHONPATH": str(ROOT)} | environment,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_importing_loads_nothing_that_draws_or_writes(tmp_path):
    text = (
        "import sys, sphsolid, fem_reference; print([m for m in sys.modules if m.split('.')[0] in "
        "('matplotlib', 'h5py', 'vtk', 'vtkmodules', 'pyvista', 'PIL', 'IPython')])"
    )
    assert python(text, tmp_path).strip() == "[]"


def test_without_matplotlib_one_sentence_says_what_to_install(tmp_path):
    text = """
import sys
sys.modules["matplotlib"] = None
import sphsolid as sph
from sphsolid.record import History
for call in (lambda: History.of([{"time [s]": 0.0, "a": 1.0}]).plot(), lambda: sph.compare(1, 2),
             lambda: sph.animate("x")):
    try:
        call()
    except sph.InputError as error:
        print(error)
"""
    said = python(text, tmp_path).splitlines()
    assert len(said) == 3
    assert all("pip install 'sphsolid[look]'" in line for line in said)


def test_without_pyvista_one_sentence_says_what_to_install(tmp_path, ran):
    text = f"""
import sys
sys.modules["pyvista"] = None
from sphsolid.shell import main
code = main(["view", {str(ran["sph"].folder)!r}, "--window"])
print(code, file=sys.stderr)
"""
    clean = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, "-c", text], capture_output=True, text=True, env=clean, timeout=300
    )
    assert "pip install 'sphsolid[render]'" in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stderr.strip().endswith("2")


def test_pictures_need_no_display_and_no_home(tmp_path, ran):
    text = f"""
import sphsolid as sph
from sphsolid.record.stored import frame_files, read_frame
folder = {str(ran["fem"].folder)!r}
read_frame(frame_files(folder)[-1][1]).picture(path="p.png")
print(sph.animate(folder, path="a.gif"))
"""
    assert python(text, tmp_path, MPLCONFIGDIR=str(tmp_path)).strip() == "a.gif"
    assert (tmp_path / "p.png").stat().st_size > 1000


# ---------------------------------------------------------------------- what may be installed
def test_a_body_for_pyvista(ran):
    pyvista = pytest.importorskip("pyvista")
    from sphsolid.look.window import grid_of

    for method in ("sph", "fem"):
        frame = read_frame(frame_files(ran[method].folder)[-1][1])
        grid = grid_of(frame, "von_mises")
        assert isinstance(grid, pyvista.UnstructuredGrid)
        assert (grid.n_points, grid.n_cells) == (len(frame.X), len(frame.mesh.cells))
        np.testing.assert_array_equal(grid.points, frame.x)
        np.testing.assert_array_equal(grid.point_data["von_mises"], frame.at_vertices("von_mises"))
        assert (grid.compute_cell_sizes()["Volume"] > 0.0).all()
