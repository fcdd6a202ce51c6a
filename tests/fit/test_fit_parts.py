"""Consistency by part of the tracks: which part a row is in, and NIS that is chi-square where the filter is right."""

from __future__ import annotations

import numpy as np
import pytest

import jink
from jink.fit import fit
from jink.fit.fitting import training_data
from jink.fit.regimes import PARTS, innovations, parts, shares
from jink.models.tracks import Tracks


def flight(sd=0.0, seed=0, heights=True):
    """60 s each: at rest, straight on at 100 m/s, turning by 3°/s, straight on climbing with 10 m/s; one row per
    second.
    """
    t = np.arange(240.0)
    speed = np.where(t < 60, 0.0, 100.0)
    course = np.radians(3.0 * np.clip(t - 120.0, 0.0, 60.0))
    climb = np.where(t >= 180, 10.0, 0.0)
    steps = np.column_stack([speed * np.sin(course), speed * np.cos(course), climb])
    z = np.cumsum(steps, axis=0) + sd * np.random.default_rng(seed).standard_normal((240, 3))
    return t, z if heights else z[:, :2]


@pytest.mark.parametrize("heights", [True, False])
def test_parts_are_what_the_target_does(heights):
    t, z = flight(heights=heights)
    found = parts(Tracks(t, z, np.array([0, 240])), np.full(z.shape[1], 1e-4))
    for name, middle in (("standing", 30), ("straight", 90), ("turning", 150), ("climbing", 210)):
        expected = name if heights or name != "climbing" else "straight"
        assert {PARTS[k] for k in found[middle - 15 : middle + 15]} == {expected}
    assert (found[:10] == -1).all() and (found[-10:] == -1).all()


def test_a_gap_is_in_no_part_and_noise_is_no_turn():
    t, z = flight(sd=200.0)
    found = parts(Tracks(t, z, np.array([0, 240])), np.full(3, 200.0**2))
    assert not (found[75:105] == PARTS.index("turning")).any()
    t, z = flight()
    z[80:110] = np.nan
    found = parts(Tracks(t, z, np.array([0, 240])), np.full(3, 1e-4))
    assert (found[80:110] == -1).all()


def test_nis_of_the_right_filter_is_inside_its_band_and_that_of_a_wrong_one_is_not():
    rng = np.random.default_rng(3)
    n, T = 40, 150
    time = np.tile(np.arange(float(T)), n)
    start = rng.standard_normal((n, 1, 2)) * 50 + 100
    v = start + np.cumsum(rng.standard_normal((n, T, 2)) * 0.1, axis=1)
    z = (np.cumsum(v, axis=1) + 5.0 * rng.standard_normal((n, T, 2))).reshape(-1, 2)
    tracks = Tracks(time, z, np.arange(n + 1) * T, owner=np.arange(n))
    right, timid, bold = (
        jink.Kalman(jink.ConstantVelocity(acceleration_psd=0.01), jink.Position(sd=sd)) for sd in (5.0, 15.0, 2.0)
    )
    for filter, low, high in ((right, 0.935, 0.965), (timid, 0.0, 0.9), (bold, 0.0, 0.9)):
        found = {s.part: s for s in shares(filter, tracks)}["straight"]
        assert low < found.inside.value < high and found.rows > 4000
        assert found.inside.value + found.below + found.above == pytest.approx(1.0)
    est = right.filter(**tracks.keywords())
    nis, dof = innovations(right, tracks)
    np.testing.assert_allclose(nis[dof > 0], est.nis[dof > 0], rtol=1e-9)
    assert {s.part: s.below > s.above for s in shares(timid, tracks)}["straight"]


def test_a_reading_that_repeats_is_no_test():
    t, z = flight(sd=3.0)
    z[:, 2] = 1000.0 + 7.62 * np.round(z[:, 2] / 7.62)
    same = Tracks(t, z, np.array([0, 240])).repeated
    assert not same[:, :2].any() and same[:, 2].mean() > 0.3
    filter = jink.Kalman(jink.ConstantVelocity(acceleration_psd=1.0), jink.Position(sd=3.0, axes=3))
    _, dof = innovations(filter, Tracks(t, z, np.array([0, 240])))
    np.testing.assert_array_equal(dof[2:], np.where(same[:, 2], 2, 3)[2:])


def recorded(tmp_path, targets, parked):
    """Targets that fly straight, and parked ones that send one position again and again; each in two parts."""
    rng = np.random.default_rng(1)
    lines = ["target,time,x,y"]
    for k in range(targets + parked):
        for second in (*range(100), *range(2000, 2100)):
            x, y = (50.0 * second, 30.0 * k) if k < targets else (10.0 * k, 0.0)
            off = 4.0 * rng.standard_normal(2) if k < targets else np.zeros(2)
            lines.append(f"{k},{second},{x + off[0]:.3f},{y + off[1]:.3f}")
    path = tmp_path / "seen.csv"
    path.write_text("\n".join(lines))
    return str(path)


def test_files_are_split_by_target_and_repeats_do_not_count(tmp_path):
    path = recorded(tmp_path, 12, 6)
    asked = {"runs": 1, "check_runs": 1, "seed": 0, "kind": "vehicle", "columns": None, "truth": None}
    training = training_data(path, **asked)
    fitted, held = (set(np.asarray(each.owner).tolist()) for each in (training.tracks, training.held_out))
    assert not fitted & held and all(name in held or int(name) >= 12 for name in set(map(str, range(18))) - fitted)
    assert all(int(name) < 12 for name in held | fitted)


def test_a_fit_says_how_consistent_each_part_is(tmp_path):
    found = fit(recorded(tmp_path, 12, 0), "kalman-cv", kind="vehicle", starts=1)
    told = {s["part"]: s for s in found.as_dict()["nis_by_part"]["fitted"]}
    assert 0.9 < told["straight"]["inside"] < 0.98 and told["straight"]["rows"] > 500


def test_a_file_with_truth_is_judged_by_it(tmp_path):
    from jink.scenarios import by_name
    from jink.scenarios.table import simulation_table

    path = tmp_path / "seen.csv"
    simulation_table(by_name("random-turns").simulate(24, 1)).write_csv(path)
    found = fit(str(path), "kalman-cv", kind="fighter", truth="true", starts=1, minutes=0.2)
    assert found.objective == "tracking" and found.judged == ["position_rmse", "velocity_rmse"]
    raw, after = (found.race.figure(name, "position_rmse").value for name in ("raw", "fitted"))
    assert raw == pytest.approx(50.0 * 2**0.5, rel=0.05) and after < raw
    tracks = found.held_out
    x = found.filter.filter(**tracks.keywords()).x[:, :1] - np.asarray(tracks.truth)[:, :1]
    y = found.filter.filter(**tracks.keywords()).x[:, 2:3] - np.asarray(tracks.truth)[:, 1:2]
    square = (x**2 + y**2)[np.asarray(tracks.counts)]
    assert after == pytest.approx(float(np.sqrt(square.mean())), rel=1e-9)
    assert any("position" in line for line in found.verdicts())


def test_the_command_says_where_it_wrote_and_the_page_shows_the_parts(tmp_path, capsys):
    from jink.cli.fit import FitRequest, run_fit

    data, out, page = recorded(tmp_path, 12, 0), tmp_path / "my.json", tmp_path / "my.html"
    request = FitRequest(data=data, output=str(out), filter="kalman-cv", kind="vehicle", starts=1, report=str(page))
    assert run_fit(request) == 0
    said = capsys.readouterr().out
    assert "NIS inside its 95% band" in said and f"--filter {out}" in " ".join(said.split())
    text = page.read_text(encoding="utf-8")
    assert "Consistency by part of the tracks" in text and "straight" in text
    assert "log-likelihood gained so far" in text and jink.load(out).fitted["kind"] == "vehicle"
