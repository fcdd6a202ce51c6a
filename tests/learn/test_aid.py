"""Correctors: recovery of a known system, training data, the native aid against NumPy, ranges, files."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import jink
from jink.filters.aided import Aided
from jink.learn.aid import correction, fit_corrector, inputs_of, position_rms, watch, weakened
from jink.learn.anfis import fit_anfis
from jink.learn.data import from_scenario, joined
from jink.learn.mlp import fit_network
from jink.models.anfis import Anfis
from jink.models.corrector import Corrector

SENSOR = jink.Position(sd=50.0, axes=1)
SLUGGISH = jink.Kalman(jink.ConstantAcceleration(jerk_psd=1e-3), SENSOR)
IMM = jink.IMM(
    [jink.ConstantVelocity(acceleration_psd=1.0), jink.ConstantAcceleration(jerk_psd=10.0)],
    SENSOR,
    jink.Sojourn(seconds=[60.0, 20.0]),
)


def aircraft(runs, seed, misses=False):
    data = from_scenario("benchmark-1", runs, seed, sensor=50.0, interval=1.0).along([1])
    if misses:
        data.z[np.random.default_rng(seed).random(data.z.shape) < 0.1] = np.nan
    return data


HYBRID = {"triangular": 0.065, "gaussian": 1e-4, "bell": 0.003}  # corners of triangles move by kinks


@pytest.mark.parametrize("kind", ["triangular", "gaussian", "bell"])
@pytest.mark.parametrize("method", ["hybrid", "backpropagation"])
def test_a_small_known_anfis_is_recovered(kind, method):
    memberships = {
        "triangular": [[-2.0, -1.0, 1.0], [-1.0, 1.0, 2.0]],
        "gaussian": [[-1.0, 0.8], [1.0, 0.8]],
        "bell": [[-1.0, 1.0, 2.0], [1.0, 1.0, 2.0]],
    }[kind]
    truth = Anfis(kind, [memberships] * 2, [[[1.0, 0, 0]], [[0, 1.0, 0.5]], [[-1.0, 0, 0]], [[0, -1.0, -0.5]]])
    rng = np.random.default_rng(0)
    u, fresh = rng.uniform(-1.5, 1.5, (2, 600, 2))
    found = fit_anfis(u, truth(u), kind=kind, functions=2, method=method, epochs=400, rate=0.02, ridge=1e-9)
    rms = np.sqrt(np.mean((found(fresh) - truth(fresh)) ** 2)) / truth(fresh).std()
    assert rms < (HYBRID[kind] if method == "hybrid" else 0.035)


def test_a_known_network_is_learned():
    rng = np.random.default_rng(0)
    u = rng.normal(size=(2000, 2))
    y = np.tanh(u[:, :1] - u[:, 1:])
    found = fit_network(u, y, hidden=(8,), epochs=150, batch=128, rate=0.02)
    fresh = rng.normal(size=(500, 2))
    assert np.sqrt(np.mean((found(fresh) - np.tanh(fresh[:, :1] - fresh[:, 1:])) ** 2)) < 0.001
    assert fit_network(u, y, hidden=(8,), epochs=3) == fit_network(u, y, hidden=(8,), epochs=3)


def test_what_the_filter_saw():
    runs = aircraft(2, 1, misses=True)
    seen = watch(SLUGGISH, runs)
    plain = SLUGGISH.filter(**runs.batch())
    assert_allclose(seen.estimate["position"].ravel(), plain.x[:, 0], rtol=1e-12)
    used = seen.updated[..., 0].ravel()
    assert_allclose((seen.innovation**2 / seen.S).ravel()[used], plain.nis[used], rtol=1e-8)
    u = inputs_of("innovations", 3, seen)[0, :, 0]
    taken = np.flatnonzero(seen.updated[0, :, 0])
    normal = (seen.innovation / np.sqrt(seen.S))[0, taken, 0]
    assert_array_equal(u[taken[5]], normal[[5, 4, 3]])  # a miss enters no innovation
    assert_array_equal(u[taken[0]], [normal[0], 0.0, 0.0])


@pytest.mark.parametrize("filter", [SLUGGISH, IMM], ids=["kalman", "imm"])
@pytest.mark.parametrize(
    ("inputs", "count", "corrects"),
    [
        ("titi-guney", 2, ("position",)),
        ("innovations", 4, ("position", "velocity")),
        ("sums", 3, ("position", "velocity")),
    ],
)
@pytest.mark.parametrize("model", ["anfis", "network"])
def test_the_native_aid_adds_what_numpy_says(filter, inputs, count, corrects, model):
    settings = {"functions": 2, "epochs": 3} if model == "anfis" else {"epochs": 3}
    corrector = fit_corrector(
        filter,
        aircraft(3, 1),
        aircraft(2, 2),
        model=model,
        inputs=inputs,
        count=count,
        corrects=corrects,
        **settings,
    )
    runs = aircraft(3, 7, misses=True)
    runs.z[1, 100] += 500.0  # outside the training range
    aided = Aided(filter, corrector).filter(**runs.batch())
    alone = filter.filter(**runs.batch())
    added = correction(corrector, watch(filter, runs))
    assert any(np.nanmax(np.abs(c)) > 1 for c in added.values())
    for name, values in added.items():
        column = alone.components.index(f"{name[0]}x")
        assert_allclose(aided.x[:, column], alone.x[:, column] + values.ravel(), rtol=1e-8, atol=1e-6)


def test_sums_are_of_the_newest_one_two_and_four():
    seen = watch(SLUGGISH, aircraft(2, 1, misses=True))
    last, sums = inputs_of("innovations", 4, seen), inputs_of("sums", 3, seen)
    for k in range(3):
        assert_allclose(sums[..., k], last[..., : 2**k].sum(axis=-1) / np.sqrt(2**k), atol=1e-12)


@pytest.mark.parametrize("filter", [SLUGGISH, IMM], ids=["kalman", "imm"])
def test_p_goes_out_with_the_factors_of_the_corrector(filter):
    """W P W with W = 1 + f (factor − 1), f the share; the filter's own P where nothing is corrected. Live as well."""
    found = fit_corrector(filter, aircraft(3, 1), aircraft(2, 2), model="linear")
    corrector = replace(found, sd_factors=(1.5, 2.0, 0.5))
    runs = aircraft(3, 7, misses=True)
    runs.z[1, 100] += 500.0  # outside the training range
    alone, aided = (f.filter(**runs.batch()) for f in (filter, Aided(filter, corrector)))
    seen = watch(filter, runs)
    share = corrector.share(inputs_of("titi-guney", 2, seen).reshape(-1, 2))
    share = np.where(seen.updated.ravel(), share, 0.0)
    assert (share == 1).any() and ((share > 0) & (share < 1)).any() and (share == 0).any()
    W = 1 + share[:, None] * (np.array([1.5, 2.0, 0.5]) - 1)
    assert_allclose(aided.P, alone.P * W[:, :, None] * W[:, None, :], rtol=1e-9)
    assert_array_equal(aided.nis, alone.nis)
    live, batch = Aided(filter, corrector).start(), runs.take([1]).batch()
    places = slice(runs.z.shape[1], 2 * runs.z.shape[1])
    got = [live.update(t, z).P for t, z in zip(batch["time"], batch["z"], strict=True)]
    assert_allclose(np.stack(got), aided.P[places], rtol=1e-9)
    many = Aided(filter, corrector).start(3)
    got = [many.update(t, z).P for t, z in zip(runs.time[0], np.moveaxis(runs.z, 0, 1), strict=True)]
    assert_allclose(np.stack(got, axis=1).reshape(aided.P.shape), aided.P, rtol=1e-9)


@pytest.mark.parametrize("model", ["anfis", "linear"])
def test_what_an_aid_learns_about_p_keeps_its_nees_honest(model):
    """The mean NEES of position and velocity on unseen runs: far above 1 without, 1 with it."""
    settings = {"epochs": 5} if model == "anfis" else {}
    corrector = fit_corrector(SLUGGISH, aircraft(20, 1), aircraft(20, 2), model=model, **settings)
    test = aircraft(40, 9)
    truth = np.concatenate([test.position, test.velocity], axis=2).reshape(-1, 2)

    def nees(corrector):
        found = Aided(SLUGGISH, corrector).filter(**test.batch())
        e = (found.x[:, :2] - truth).reshape(40, -1, 2)[:, 2:].reshape(-1, 2)
        P = found.P[:, :2, :2].reshape(40, -1, 2, 2)[:, 2:].reshape(-1, 2, 2)
        return float(np.einsum("ni,nij,nj->n", e, np.linalg.inv(P), e).mean() / 2)

    assert nees(replace(corrector, sd_factors=())) > 100
    # twenty runs to learn from and forty to judge by leave some per cent of chance
    assert nees(corrector) == pytest.approx(1.0, abs=0.15)


def test_factors_of_p_by_hand():
    """One axis, position and velocity: wᵀ A w of the reciprocals is the number of components."""
    from jink.learn.aid import correction as added
    from jink.learn.aid import sd_factors

    corrector = fit_corrector(SLUGGISH, aircraft(3, 1), aircraft(2, 2), model="linear")
    runs = aircraft(4, 5)
    seen = watch(SLUGGISH, runs)
    factors = np.array(sd_factors(SLUGGISH, runs, corrector))
    good = seen.updated[..., 0]
    e = np.stack([(seen.estimate[n] - getattr(runs, n))[good][:, 0] for n in ("position", "velocity")], axis=1)
    e[:, 0] += added(corrector, seen)["position"][good][:, 0]
    scaled = e / factors[:2]
    P = seen.P[:, :, 0][good][:, :2, :2]
    assert_allclose(np.einsum("ni,nij,nj->n", scaled, np.linalg.inv(P), scaled).mean(), 2.0, rtol=1e-9)


def climb(runs, seed):
    """Along z, where the same aircraft does not manoeuvre: an aid learned along x spoils a sluggish filter."""
    return from_scenario("benchmark-1", runs, seed, sensor=50.0, interval=1.0).along([2])


def test_an_aid_is_weakened_until_it_hurts_no_kind_of_target():
    """The gain is the least of Σ ea / Σ a² less two standard errors, family by family, by hand."""
    found = fit_corrector(SLUGGISH, aircraft(10, 1), aircraft(5, 2), model="linear")
    checked = joined([aircraft(8, 2), climb(8, 2)])
    assert checked.family.tolist() == [0] * 8 + [1] * 8
    assert checked.take([3, 9]).family.tolist() == [0, 1]
    weak, (gain,) = weakened(SLUGGISH, checked, found)
    bounds = []
    for runs in (aircraft(8, 2), climb(8, 2)):
        seen = watch(SLUGGISH, runs)
        a = np.where(seen.updated, correction(found, seen)["position"], 0.0)
        e = np.where(seen.updated, runs.position - seen.estimate["position"], 0.0)
        ea, aa = (e * a).sum(axis=(1, 2)), (a * a).sum(axis=(1, 2))
        best = ea.sum() / aa.sum()
        bounds.append(best - 2 * (ea - best * aa).std(ddof=1) / np.sqrt(8) / aa.mean())
    assert bounds[1] < 0.5 < bounds[0]
    assert gain == pytest.approx(min(max(min(bounds), 0.0), 1.0), rel=1e-9)
    assert_allclose(weak.output_scale, gain * np.array(found.output_scale), rtol=1e-12)
    fresh = climb(40, 9)
    alone = position_rms(SLUGGISH, fresh)
    assert position_rms(SLUGGISH, fresh, weak) <= alone < position_rms(SLUGGISH, fresh, found)


def test_an_aid_that_helps_keeps_its_strength():
    found = fit_corrector(SLUGGISH, aircraft(10, 1), aircraft(5, 2), model="linear")
    weak, (gain,) = weakened(SLUGGISH, aircraft(10, 3), found)
    assert 0.9 < gain <= 1.0
    test = aircraft(20, 9)
    assert position_rms(SLUGGISH, test, weak) < 0.35 * position_rms(SLUGGISH, test)


def test_one_run_has_no_standard_error():
    """Its gain is the best for itself."""
    found = fit_corrector(SLUGGISH, aircraft(10, 1), aircraft(5, 2), model="linear")
    one = aircraft(1, 3)
    _, (gain,) = weakened(SLUGGISH, one, found)
    assert 0.5 < gain <= 1.0
    off = replace(found, output_scale=(3 * found.output_scale[0],))
    weak, (third,) = weakened(SLUGGISH, one, off)
    assert third == pytest.approx(gain / 3, rel=1e-9) or gain == 1.0
    assert weak.output_scale[0] == pytest.approx(gain * found.output_scale[0], rel=1e-9) or gain == 1.0


@pytest.mark.parametrize("kind", ["triangular", "gaussian", "bell"])
def test_outside_the_training_range_the_aid_fades(kind):
    corrector = fit_corrector(SLUGGISH, aircraft(3, 1), aircraft(2, 2), kind=kind, epochs=3)
    low, high = np.array(corrector.low), np.array(corrector.high)
    corner, width = (
        np.array([high[0], low[1]]),
        np.array([1.0, -1.0]) * (high - low),
    )  # the inputs have opposite signs
    inside, near, far = corner - 1e-9 * width, corner + 0.25 * width, corner + 0.6 * width
    assert_allclose(corrector.share([inside, near, far]), [1.0, 0.5, 0.0], atol=1e-6)
    answers = corrector(np.array([inside, near, far, 1e9 * corner]))[:, 0]
    assert np.isfinite(answers).all()
    assert_allclose(answers[1:], [0.5 * answers[0], 0.0, 0.0], rtol=1e-5)


def test_the_aid_rescues_a_sluggish_filter_on_unseen_runs():
    test = aircraft(30, 9)
    aids = {m: fit_corrector(SLUGGISH, aircraft(10, 1), aircraft(5, 2), model=m) for m in ("linear", "anfis")}
    alone = position_rms(SLUGGISH, test)[0]
    rms = {model: position_rms(SLUGGISH, test, aid)[0] for model, aid in aids.items()}
    assert rms["linear"] < 0.3 * alone and rms["anfis"] < rms["linear"]


def test_an_aided_filter_comes_back_from_its_file_bit_for_bit(tmp_path):
    corrector = fit_corrector(SLUGGISH, aircraft(3, 1), aircraft(2, 2), epochs=3)
    filter, path = Aided(SLUGGISH, corrector), tmp_path / "aided.json"
    filter.save(path)
    again = jink.load(path)
    assert again.corrector == corrector
    batch = aircraft(2, 5).batch()
    assert_array_equal(again.filter(**batch).x, filter.filter(**batch).x)


def test_an_aid_s_file_in_wrong_units_is_refused(tmp_path):
    path = tmp_path / "aided.json"
    Aided(SLUGGISH, fit_corrector(SLUGGISH, aircraft(3, 1), aircraft(2, 2), model="linear")).save(path)
    body = json.loads(path.read_text(encoding="utf-8"))
    for name in ("low", "high", "centre", "scale"):
        body["corrector"][name] = [v / 1e6 for v in body["corrector"][name]]
    path.write_text(json.dumps(body), encoding="utf-8")
    with pytest.raises(ValueError, match=r"aided\.json: Corrector: was trained on .* expected metres"):
        jink.load(path)


def test_inputs_may_have_functions_each():
    """One that has a single function divides nothing: its part is linear, and exact where the truth is."""
    rng = np.random.default_rng(0)
    u = rng.normal(size=(800, 3))
    y = np.tanh(2 * u[:, :1]) + 0.7 * u[:, 2:]
    found = fit_anfis(u, y, kind="gaussian", functions=[4, 1, 1], epochs=60)
    assert [len(m) for m in found.memberships] == [4, 1, 1] and len(found.consequents) == 4
    assert np.sqrt(np.mean((found(u) - y) ** 2)) < 0.004
    with pytest.raises(ValueError, match="functions: expected 3 numbers, one for each input, got 2"):
        fit_anfis(u, y, functions=[2, 2])


def test_an_aid_in_wrong_units_is_refused():
    corrector = fit_corrector(SLUGGISH, aircraft(3, 1), aircraft(2, 2), model="linear")
    scaled = {name: [v / 1e6 for v in getattr(corrector, name)] for name in ("low", "high", "centre", "scale")}
    with pytest.raises(ValueError, match="expected metres"):
        Aided(SLUGGISH, replace(corrector, **scaled))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"inputs": "residual"}, "inputs: expected one of titi-guney, innovations"),
        ({"low": (1.0,)}, "low: expected 2 finite numbers"),
        ({"scale": (0.0, 1.0)}, "scale: expected positive"),
        ({"corrects": ("velocity",)}, "corrects: expected the first 1 of position"),
        ({"sd_factors": (1.0, -2.0)}, "sd_factors: expected at most 3 numbers above 0"),
        ({"sd_factors": (1.0,) * 4}, "sd_factors: expected at most 3 numbers above 0"),
        ({"low": (5.0, 0.0), "high": (4.0, 1.0)}, "low: expected to lie below high"),
    ],
)
def test_correctors_that_make_no_sense_are_refused(change, message):
    model = fit_anfis(np.eye(2), np.ones((2, 1)), functions=1, epochs=0)
    given = {
        "model": model,
        "inputs": "titi-guney",
        "low": (-1.0, -1.0),
        "high": (1.0, 1.0),
        "centre": (0.0, 0.0),
        "scale": (1.0, 1.0),
        "output_scale": (1.0,),
    }
    with pytest.raises(ValueError, match=message):
        Corrector(**{**given, **change})


def test_what_cannot_be_corrected_is_said():
    constant = jink.Kalman(jink.ConstantVelocity(acceleration_psd=1.0), SENSOR)
    corrects = ("position", "velocity", "acceleration")
    with pytest.raises(ValueError, match="it does not estimate acceleration"):
        fit_corrector(constant, aircraft(3, 1), aircraft(2, 2), corrects=corrects)
    with pytest.raises(ValueError, match="inputs: expected one of titi-guney, innovations, sums"):
        fit_corrector(constant, aircraft(3, 1), aircraft(2, 2), inputs="averages")
    with pytest.raises(ValueError, match="count: expected 1 to 7 sums, got 8"):
        fit_corrector(constant, aircraft(3, 1), aircraft(2, 2), inputs="sums", count=8)
    with pytest.raises(ValueError, match="model: expected anfis, network or linear"):
        fit_corrector(constant, aircraft(3, 1), aircraft(2, 2), model="forest")


def test_runs_of_other_lengths_are_joined():
    a, b = aircraft(2, 1), from_scenario("choi-2001-1", 1, 1, sensor=50.0).along([0])
    both = joined([a, b])
    assert both.time.shape == (3, a.time.shape[1])
    assert np.isnan(both.z[2, 20:]).all() and np.isfinite(both.z[2, :20]).all()
    assert (np.diff(both.time, axis=1) >= 0).all()
