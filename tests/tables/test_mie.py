"""The Lorenz-Mie table: its axes, its means, its look-up against direct sums, and its building."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import rtbow.tables.mie.build as mie_build
from rtbow.base import jobs
from rtbow.base.errors import InputError, RtbowError, UnavailableError
from rtbow.base.jobs import on_cluster
from rtbow.physics.drop.mie import intensities
from rtbow.physics.drop.water import relative_index
from rtbow.physics.light.disc import disc_nodes
from rtbow.physics.sizes import Sizes
from rtbow.tables.mie.average import coherent, mean_efficiency, mean_intensities, node_intensities
from rtbow.tables.mie.axes import COMPACT_FILE, INDEX_RANGE, MieAxes
from rtbow.tables.mie.build import build_mie_table
from rtbow.tables.mie.lookup import MieSections, standard_axes
from rtbow.tables.mie.store import compact_table, pack, range_candidates, unpack
from rtbow.tables.sections import water_sections

pytestmark = pytest.mark.slow

STANDARD = standard_axes(0.02)
SMALL = MieAxes(0.1, 1.0, 2, INDEX_RANGE, 2.0, 2.0, 2.0, 8.0)
"""A table of few nodes, built in a moment."""
SMALL_RADII = (30.0, 45.0)


# --- Axes


@pytest.mark.parametrize("m", [*INDEX_RANGE, 1.3345, 1.3215])
def test_angles_and_places_are_inverses(m):
    angles = STANDARD.angles(m)
    assert angles[0] == 0.0
    assert angles[-1] == np.pi
    assert np.all(np.diff(angles) > 0.0)
    # 3e-9 of a node at worst.
    places = STANDARD.angle_places(angles, m)
    assert np.abs(places - np.arange(len(angles))).max() < 1e-6


def test_bows_keep_their_places_along_the_axis():
    bows = {1.3235: 136.52, 1.3450: 139.63}  # Descartes' angles, worked with a pocket calculator
    places = [STANDARD.angle_places(np.radians([deg]), m)[0] for m, deg in bows.items()]
    assert abs(places[0] - places[1]) < 3.0
    moved = STANDARD.angle_places(np.radians([138.0]), 1.3235)[0] - places[0]
    assert moved > 100.0


def test_index_weights_interpolate_polynomials():
    m = np.array([1.325, 1.34, 1.346])
    weights = STANDARD.index_weights(m)
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, rtol=1e-12)
    u = (STANDARD.index_nodes - 1.33) * 100.0
    np.testing.assert_allclose(weights @ u**4, ((m - 1.33) * 100.0) ** 4, rtol=1e-9)


# --- Means


def plain_mean(x, m, theta, spread, count):
    """Log-normal mean by the trapezoid rule, whole amplitudes: nothing shared but |S|²."""
    t = np.linspace(-4.0, 4.0, count)
    weight = np.exp(-0.5 * t**2)
    parts = [intensities(x * np.exp(spread * u), m, theta, False) / x**2 for u in t]
    scale = np.exp(-2.0 * spread * t)  # over each size's own x²
    return np.tensordot(weight * scale, np.array(parts), axes=(0, 0)) / weight.sum()


def test_mean_over_the_spread():
    theta = np.radians(np.array([5.0, 60.0, 100.0, 139.0, 145.0, 175.0]))
    x = 90.0
    got = mean_intensities(STANDARD, np.array([np.log(x)]), 1.337, theta)[0]
    np.testing.assert_allclose(got, plain_mean(x, 1.337, theta, 0.02, 6001), rtol=4e-3)


def test_orders_add_as_intensities_where_the_spread_blurs_them():
    """Debye's orders against whole amplitudes, at a size where the table changes over."""
    theta = np.radians(np.array([20.0, 50.0, 100.0, 125.0, 138.5, 140.0, 150.0, 165.0]))
    x = 560.0
    assert not coherent(STANDARD, x)
    got = mean_intensities(STANDARD, np.array([np.log(x)]), 1.337, theta)[0]
    whole = plain_mean(x, 1.337, theta, 0.02, 6001)
    # The sums over sizes differ by what resonances leave to chance: 0.4 % of the bow at worst.
    assert np.abs(got - whole).max() < 0.01 * whole[:, 4:6].max()


@pytest.mark.parametrize(("spread", "x"), [(0.01, 150.0), (0.05, 150.0), (0.1, 30.0), (0.2, 60.0)])
def test_other_spreads(spread, x):
    """A block of nodes from x on, at most as long as a build cuts them; both ends by their sums."""
    axes = standard_axes(spread)
    count = min(max(round(0.48 / axes.step), 1), 24)
    nodes = np.log(x) + np.arange(count) * axes.step
    m = float(axes.index_nodes[1])
    got = node_intensities(axes, nodes, m)
    theta = axes.angles(m)
    wanted = np.radians([3.0, 40.0, 110.0, 139.0, 144.0, 160.0, 177.0])
    at = np.array([int(np.argmin(np.abs(theta - t))) for t in wanted])
    for j in {0, count - 1}:
        size = float(np.exp(nodes[j]))
        exact = plain_mean(size, m, theta[at], spread, 4001 if spread < 0.1 else 8001)
        level = np.maximum(exact, 0.3 * exact[:, 3:5].max())
        # What resonances leave to chance: 1 % at worst.
        assert (np.abs(got[j][:, at] - exact) / level).max() < 0.03


def test_thinned_angles_lie_on_all_of_them():
    nodes = np.log(np.array([50.0]))
    got = node_intensities(STANDARD, nodes, 1.334)
    every = mean_intensities(STANDARD, nodes, 1.334, STANDARD.angles(1.334))
    assert len(STANDARD.needed_angles(50.0, 1.334)) < 0.4 * got.shape[2]
    np.testing.assert_allclose(got, every, rtol=1e-3)


def test_mean_efficiency():
    # Q_ext tends to 2 + 1.992 x^(-2/3) (Nussenzveig and Wiscombe, Phys. Rev. Lett. 45, 1490,
    # 1980; the edge term), once its ripple is averaged out.
    nodes = np.log(np.array([3000.0]))
    expected = 2.0 + 1.9924 * 3000.0 ** (-2.0 / 3.0)
    assert mean_efficiency(STANDARD, nodes, 1.334)[0] == pytest.approx(expected, rel=5e-4)


# --- Look-up


def test_the_table_that_ships():
    table = compact_table()
    assert COMPACT_FILE.stat().st_size < 8e6
    assert table.covers((1.0, 1500.0))
    assert np.isfinite(table.values).all()
    assert table.values.min() > 0.0


def test_packing_rounds_by_less_than_two_per_mille():
    rng = np.random.default_rng(3)
    table = compact_table()
    noisy = table.values * rng.uniform(0.5, 2.0, table.values.shape).astype(np.float32)
    few = type(table)(table.axes, table.first, noisy[:, :8], table.efficiency[:, :8])
    back = unpack(pack(few))
    np.testing.assert_allclose(back.values, few.values, rtol=1.4e-3)
    np.testing.assert_allclose(back.efficiency, few.efficiency, rtol=1e-6)
    assert back.first == few.first


# Between the nodes of size and index; worst deviations seen: 0.8 % of the bow's peak.
PLACES = [
    (1.0, 780.0), (8.3, 411.0), (21.7, 553.0), (52.4, 640.0), (117.0, 702.0), (233.0, 460.0),
    (700.0, 620.0), (1500.0, 381.0),
]  # fmt: skip


@pytest.mark.parametrize(("radius_um", "nm"), PLACES)
@pytest.mark.parametrize("disc_deg", [0.0, 0.533])
def test_look_up_against_direct_sums(radius_um, nm, disc_deg):
    """At radii and wavelengths between the nodes, and at the table's ends."""
    m = float(relative_index(np.array([nm]), 20.0)[0])
    x = 2.0 * np.pi * radius_um * 1e3 / nm
    disc_rad = np.radians(0.5 * disc_deg)
    theta = np.radians(
        [0.3, 2.0, 30.0, 90.0, 120.0, 126.0, 131.0, 136.0, 138.0, 139.0, 141.0, 146.0, 160.0, 178.0]
    )
    discs = [disc_nodes(t, disc_rad, 90) for t in theta]
    nodes = np.concatenate([angles for angles, _ in discs])
    every = mean_intensities(STANDARD, np.array([np.log(x)]), m, nodes)[0]
    ends = np.cumsum([0, *(len(angles) for angles, _ in discs)])
    direct = np.stack(
        [every[:, a:b] @ w for a, b, (_, w) in zip(ends[:-1], ends[1:], discs, strict=True)]
    )
    sections = MieSections(compact_table(), np.array([nm * 1e-9]), np.array([m]))
    got = sections.sections(np.array([radius_um * 1e-6]), theta, disc_rad)[0, 0]
    direct = direct * (radius_um * 1e-6) ** 2
    peak = direct[8:11].mean(axis=1).max()
    error = np.abs(got - direct).mean(axis=1) / np.maximum(peak, direct.mean(axis=1))
    # Bows of high order are sharp on drops over 1 mm and move fast with the index.
    assert error[2:].max() < (0.01 if radius_um < 1000.0 else 0.035)
    # Near the sun, of the light there: rings of a point light turn fast.
    assert error[0] < (0.03 if radius_um < 1000.0 else 0.2)
    assert error[1] < 0.03


def test_mixture_is_the_sum_of_its_sizes():
    sections = water_sections("mie", np.array([450.0, 600.0]), 20.0, (20.0, 60.0))
    sizes = Sizes(np.array([2e-5, 3.1e-5, 6e-5]), np.array([0.5, 0.2, 0.3]), 1.0)
    theta = np.radians(np.linspace(0.0, 180.0, 40))
    each = sections.sections(sizes.radius_m, theta, 0.004)
    mixed = sections.mixed(sizes, theta, 0.004)
    np.testing.assert_allclose(mixed, np.tensordot(sizes.share, each, axes=(0, 0)), rtol=1e-9)


@pytest.mark.parametrize("theory", ["airy", "mie"])
def test_theories_agree_on_the_bow_of_a_large_drop(theory):
    """Peak of the primary: Descartes' 137.9° and Airy's shift of 1.0188 / scale (Ai's maximum)."""
    sections = water_sections(theory, np.array([550.0]), 20.0, (500.0, 500.0))
    theta = np.radians(np.linspace(137.0, 140.0, 601))
    profile = sections.sections(np.array([5e-4]), theta, 0.0)[0, 0].mean(axis=1)
    assert np.degrees(theta[profile.argmax()]) == pytest.approx(138.44, abs=0.06)


def test_perpendicular_light_dominates_the_bow():
    # At the primary's angle of incidence the inner reflection is near Brewster's angle.
    sections = water_sections("mie", np.array([550.0]), 20.0, (500.0, 500.0))
    both = sections.sections(np.array([5e-4]), np.radians([138.4]), 0.00465)[0, 0, 0]
    assert both[0] / both[1] > 10.0


def test_sizes_beyond_the_table_are_refused():
    sections = MieSections(compact_table(), np.array([500e-9]), np.array([1.335]))
    for radius_m in (1e-7, 4e-3):
        with pytest.raises(InputError, match="size parameters"):
            sections.sections(np.array([radius_m]), np.array([2.0]), 0.0)


def test_damaged_tables_are_told():
    data = COMPACT_FILE.read_bytes()
    for wrong in (data[:-10], data[:100] + b"\0" + data[101:], b"", data[:40]):
        with pytest.raises(RtbowError, match="install rtbow anew"):
            unpack(wrong)


@pytest.mark.parametrize("radii", [(1.0, 1500.0), (300.0, 300.0), (20.0, 700.0), (2000.0, 2000.0)])
def test_few_ranges_serve_all_radii(radii):
    for low, high in range_candidates(radii):
        assert low <= radii[0]
        assert radii[1] <= high
    assert range_candidates(radii)[0][1] <= 2.6 * radii[1]


def test_wavelengths_and_temperatures_beyond_the_table_are_refused(monkeypatch):
    # Before any table is looked for, which might have to be built.
    monkeypatch.setattr("rtbow.tables.sections.mie_table", lambda *_: pytest.fail("too late"))
    with pytest.raises(InputError, match=r"refractive index of 1\.334.* to 1\.416"):
        water_sections("mie", np.array([205.0, 550.0]), 20.0, (10.0, 10.0))


# --- Building


@pytest.fixture(scope="module")
def expected():
    """The small table, computed in this very process."""
    nodes = mie_build.node_range(SMALL, SMALL_RADII)
    every = mie_build.parts(SMALL, nodes)
    return mie_build._join(SMALL, nodes, {part: mie_build.compute_part(part) for part in every})


def same(table, expected):
    np.testing.assert_array_equal(table.values, expected.values)
    np.testing.assert_array_equal(table.efficiency, expected.efficiency)
    assert table.first == expected.first


def test_processes_build_the_same_table_and_keep_it(empty_cache, expected):
    seen = []

    def progress(items):
        for item in items:
            yield item
            seen.append(item)

    same(build_mie_table(SMALL, SMALL_RADII, progress, workers=2), expected)
    assert seen == list(range(len(seen)))
    assert seen
    kept = sorted(path.name for path in empty_cache.glob("*.npz"))
    assert len(kept) == 1
    assert kept[0].startswith("mie-")
    # From the cache now: no part is computed.
    same(build_mie_table(SMALL, SMALL_RADII, workers=1), expected)


def test_a_stopped_build_goes_on_where_it_was(empty_cache, expected, monkeypatch):
    every = mie_build.parts(SMALL, mie_build.node_range(SMALL, SMALL_RADII))

    def stopped(_work, todo, _workers):
        for part in todo[: len(todo) // 2]:
            yield part, mie_build.compute_part(part)
        raise KeyboardInterrupt

    monkeypatch.setattr(mie_build, "in_processes", stopped)
    with pytest.raises(KeyboardInterrupt):
        build_mie_table(SMALL, SMALL_RADII)
    assert len(list(empty_cache.glob("mie-part-*.npz"))) == len(every) // 2
    computed = []

    def rest(_work, todo, _workers):
        for part in todo:
            computed.append(part)
            yield part, mie_build.compute_part(part)

    monkeypatch.setattr(mie_build, "in_processes", rest)
    same(build_mie_table(SMALL, SMALL_RADII), expected)
    assert len(computed) == len(every) - len(every) // 2
    assert not list(empty_cache.glob("mie-part-*.npz"))


def children(parent=None):
    me = parent or os.getpid()
    found = []
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/stat") as file:
                fields = file.read().rpartition(")")[2].split()
            with open(f"/proc/{pid}/cmdline") as file:
                command = file.read()
        except OSError:
            continue
        if int(fields[1]) == me and "spawn_main" in command:
            found.append(int(pid))
    return found


def test_a_killed_process_costs_its_part_only(empty_cache, expected):
    def kill_one():
        for _ in range(400):
            if len(children()) >= 2:
                os.kill(children()[0], signal.SIGKILL)
                return
            time.sleep(0.05)

    killer = threading.Thread(target=kill_one)
    killer.start()
    same(build_mie_table(SMALL, SMALL_RADII, workers=2), expected)
    killer.join()


def test_processes_end_with_a_killed_parent(empty_cache):
    code = (
        "from rtbow.tables.mie.build import build_mie_table\n"
        "from rtbow.tables.mie.axes import MieAxes\n"
        "if __name__ == '__main__':\n"
        "    axes = MieAxes(0.02, 1.0, 5, (1.33, 1.34), 30.0, 30.0, 30.0, 1.0)\n"
        "    build_mie_table(axes, (200.0, 1500.0))\n"
    )
    script = empty_cache.parent / "build.py"
    script.write_text(code, "utf-8")
    parent = subprocess.Popen([sys.executable, str(script)])
    for _ in range(600):
        if len(children(parent.pid)) >= 2:
            break
        time.sleep(0.05)
    orphans = children(parent.pid)
    assert len(orphans) >= 2
    time.sleep(2.0)  # they import what starts the watch
    parent.kill()
    parent.wait()
    for _ in range(600):
        if not any(os.path.exists(f"/proc/{pid}") for pid in orphans):
            return
        time.sleep(0.05)
    pytest.fail("processes are left")


def test_processes_that_keep_dying_are_told(empty_cache, monkeypatch):
    class Pool:
        def __init__(self, *_args, **_keys):
            raise jobs.BrokenProcessPool

    monkeypatch.setattr(jobs, "ProcessPoolExecutor", Pool)
    with pytest.raises(RtbowError, match="fewer --workers"):
        build_mie_table(SMALL, SMALL_RADII)


def test_a_cluster_that_loses_a_worker_builds_the_same_table(empty_cache, expected):
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1"
    ) as cluster:
        done = []

        def progress(items):
            for item in items:
                yield item
                done.append(item)
                if len(done) == 2:
                    worker = next(iter(cluster.workers.values()))
                    os.kill(worker.pid, signal.SIGKILL)

        table = build_mie_table(SMALL, SMALL_RADII, progress, scheduler=cluster.scheduler_address)
    same(table, expected)
    assert len(done) > 2


def test_no_scheduler():
    with pytest.raises(UnavailableError, match="no Dask scheduler answers there"):
        list(on_cluster(mie_build._checked_part, [], "tcp://127.0.0.1:1", ""))


def test_scenes_find_the_tables_that_were_built(empty_cache, monkeypatch):
    import rtbow.tables.mie.store as mie_store

    monkeypatch.setattr(mie_store, "standard_axes", lambda *_: SMALL)
    monkeypatch.setattr(mie_store, "_held", {})
    first = mie_store.mie_table(0.1, (60.0, 90.0))
    assert first.covers((60.0, 90.0))

    def fail(*_args):
        raise AssertionError("another table for radii that one holds already")

    monkeypatch.setattr(mie_store, "build_mie_table", fail)
    monkeypatch.setattr(mie_store, "_held", {})
    same(mie_store.mie_table(0.1, (70.0, 140.0)), first)
