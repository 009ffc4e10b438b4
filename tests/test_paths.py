"""Paths: on the dome where they say so, evenly travelled, and CSV files refused cell by cell."""

import numpy as np
import pytest

from contarm_sim import paths
from contarm_sim.errors import InputError
from contarm_sim.kinematics import arc, dome
from contarm_sim.paths import shapes
from contarm_sim.paths.waypoints import from_waypoints, read_csv

LENGTH = 0.37


@pytest.mark.parametrize("name", ["spiral", "circle", "line", "figure-eight"])
def test_paths_on_the_dome_are_reached_exactly(name):
    time, targets = paths.named(name, LENGTH, duration=3.0).targets(100)
    assert len(time) == len(targets) == 301
    assert dome.bend_from_tip(targets, LENGTH).miss.max() < 1e-14


@pytest.mark.parametrize("name", paths.NAMES)
def test_paths_start_and_stop_softly_and_keep_an_even_speed(name):
    _, targets = paths.named(name, LENGTH, duration=8.0).targets(100)
    speed = np.linalg.norm(np.diff(targets, axis=0), axis=1) * 100
    assert speed[0] < 0.02 * speed.max()
    assert speed[-1] < 0.02 * speed.max()
    acceleration = np.abs(np.diff(speed)) * 100
    assert acceleration.max() < 8 * speed.max() / (shapes.RAMP * 8.0)


def test_tight_turns_are_taken_slowly():
    """Between start and stop, centripetal acceleration stays below (even speed)^2 over the path's extent."""
    _, targets = paths.named("spiral", LENGTH, turns=4).targets(1000)
    velocity = np.gradient(targets, 1e-3, axis=0)
    acceleration = np.gradient(velocity, 1e-3, axis=0)
    velocity, acceleration = velocity[1000:-1000], acceleration[1000:-1000]
    speed = np.linalg.norm(velocity, axis=1)
    centripetal = np.linalg.norm(np.cross(velocity, acceleration), axis=1) / speed
    extent = np.ptp(targets, axis=0).max()
    even = speed * np.sqrt(1 + centripetal / speed**2 * extent)
    np.testing.assert_allclose(even, even.mean(), rtol=0.01)
    assert centripetal.max() <= even.mean() ** 2 / extent


def test_spiral_ends_at_its_largest_bend_after_its_turns():
    path = paths.named("spiral", LENGTH, turns=2.25, max_bend=2.0)
    bend = dome.bend_from_tip(path.curve(np.array([0.0, 1.0])), LENGTH).bend
    np.testing.assert_allclose(bend, [[0, 0], [0, 2.0]], atol=1e-13)


def test_sphere_spiral_lies_on_its_shell_and_off_the_dome():
    centre = np.array([0.01, 0.0, 0.05])
    path = paths.named("sphere-spiral", LENGTH, sphere_radius=0.3, sphere_centre=tuple(centre))
    _, targets = path.targets(50)
    np.testing.assert_allclose(np.linalg.norm(targets - centre, axis=-1), 0.3, rtol=1e-12)
    np.testing.assert_allclose(targets[0], centre + np.array([0, 0, 0.3]), atol=1e-15)
    assert dome.bend_from_tip(targets, LENGTH, "nearest").miss.max() > 0.01


def _write(tmp_path, text, name="targets.csv"):
    file = tmp_path / name
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return file


def test_waypoints_are_passed_and_the_way_between_them_stays_on_the_dome(tmp_path):
    bends = arc.from_polar(np.array([0.0, 0.8, 1.6, 2.0]), np.array([0.0, 0.5, 1.5, 3.0]))
    points = arc.position(bends, LENGTH)
    rows = "\n".join(f"{t},{x!r},{y!r},{z!r}" for t, (x, y, z) in zip((0, 1, 3, 4), points.tolist(), strict=True))
    waypoints = read_csv(_write(tmp_path, f"t, x ,Y,z\n{rows}\n"))
    path = from_waypoints(waypoints, LENGTH)
    assert path.duration == 4
    time, targets = path.targets(100)
    np.testing.assert_allclose(targets[[0, 100, 300, 400]], points, atol=1e-12)
    assert time[-1] == 4
    assert dome.bend_from_tip(targets, LENGTH).miss.max() < 1e-12


def test_columns_may_come_in_any_order_and_with_a_byte_order_mark(tmp_path):
    waypoints = read_csv(_write(tmp_path, b"\xef\xbb\xbfname,z,y,x\na,3,2,1\n\nb,6,5,4\n"))
    np.testing.assert_array_equal(waypoints.positions, [[1, 2, 3], [4, 5, 6]])
    assert waypoints.times is None
    assert waypoints.places[1].endswith("row 4")
    assert waypoints.notes[0].endswith("not read: column 'name'")


@pytest.mark.parametrize(
    "text",
    ["time,x,y,z\n0,0.1,0,0.3\n1.5,0.2,0,0.3\n", "time [s],x [mm],y [mm],z [mm]\n0,100,0,300\n1.5,200,0,300\n",
     "T;X;Y;Z\n0;0,1;0;0,3\n1,5;0,2;0;0,3\n", "t\tx\ty\tz\n0\t0.1\t0\t0.3\n1.5\t0.2\t0\t0.3\n",
     "0,0.1,0,0.3\n1.5,0.2,0,0.3\n", "time (ms),x_m,y_m,z_mm\n0,0.1,0,300\n1500,0.2,0,300\n",
     "qw,time,x,y,z\n1,0,0.1,0,0.3\n1,1.5,0.2,0,0.3\n"],
)  # fmt: skip
def test_the_same_path_may_be_written_in_many_ways(tmp_path, text):
    waypoints = read_csv(_write(tmp_path, text))
    np.testing.assert_allclose(waypoints.positions, [[0.1, 0, 0.3], [0.2, 0, 0.3]], rtol=1e-15)
    np.testing.assert_allclose(waypoints.times, [0, 1.5])
    assert any("from mm to m" in note for note in waypoints.notes) == ("mm" in text)


@pytest.mark.parametrize(
    ("text", "said"),
    [("", "empty"), ("\n\n", "empty"), ("x,y,z\n", "without rows"), ("x,y\n1,2\n", "missing: z"), 
     ("1,2\n4,5\n", "2 columns without a header"), ("x;y;z\n0,1;0.2;1,2,3\n", "column z is '1,2,3'"),
     ("x,y,z\n0,1,0,2,0,3\n", "decimal commas"), ("x [s],y,z\n0,0,1\n", "unit of column x is 's'"),
     ("x y z\n0 0 1\n", "missing: x"), ("0 0 1\n0 0 2\n", "missing: x"), ("t,time,x,y,z\n0,0,0,0,1\n", "once"),
     ("x,y,z\n1,2,3\n1,two,3\n", "row 3, column y is 'two'"), ("x,y,z\n1,2\n", "row 2, column z is ''"),
     ("x,y,z\n1,2,nan\n", "row 2, column z is 'nan'"), ("t,x,y,z\n0,0,0,1\n0,0,0,2\n", "t in row 3"),
     (bytes(range(256)), "not text"), (b"x,y,z\n\0\0\0", "not text")],
)  # fmt: skip
def test_bad_files_are_one_clear_line(tmp_path, text, said):
    file = _write(tmp_path, text)
    with pytest.raises(InputError) as caught:
        read_csv(file)
    assert said in str(caught.value)
    assert str(file) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_missing_files_single_rows_and_standing_still_are_refused(tmp_path):
    with pytest.raises(InputError, match="No such file"):
        read_csv(tmp_path / "none.csv")
    with pytest.raises(InputError, match="at least two rows"):
        from_waypoints(read_csv(_write(tmp_path, "x,y,z\n0,0,0.37\n")), LENGTH)
    with pytest.raises(InputError, match="row 3"):
        from_waypoints(read_csv(_write(tmp_path, "x,y,z\n0,0,0.37\n0,0,0.37\n")), LENGTH)


@pytest.mark.parametrize(
    "given", [{"duration": 0}, {"duration": -1}, {"duration": np.nan}, {"duration": 1e9}, {"turns": 0},
              {"max_bend": np.pi}, {"sphere_radius": -1}],
)  # fmt: skip
def test_unusable_numbers_are_refused(given):
    with pytest.raises(InputError) as caught:
        paths.named("sphere-spiral", LENGTH, **given)
    assert caught.value.name in given


def test_unknown_paths_are_refused_with_the_known_ones():
    with pytest.raises(InputError, match="figure-eight"):
        paths.named("spirale", LENGTH)
