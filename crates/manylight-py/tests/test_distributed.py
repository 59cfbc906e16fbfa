"""`manylight.distributed`: the bits of one run, whatever dies."""

import os
import signal
import socket
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

distributed = pytest.importorskip("distributed", reason="the package `distributed` is not installed")

import dask  # noqa: E402

import manylight as ml  # noqa: E402
from manylight.distributed import render  # noqa: E402
from manylight.distributed.cluster import Cluster, check_workers  # noqa: E402
from manylight.distributed.folder import Folder  # noqa: E402
from manylight.distributed.rounds import Progress, next_round  # noqa: E402
from manylight.distributed.settings import goal_of  # noqa: E402
from manylight.distributed.shares import (  # noqa: E402
    blocks_of,
    cut,
    disjoint,
    gaps,
    part_name,
    share_count,
)

SCENE = Path(__file__).resolve().parents[3] / "scenes" / "glossy-cornell" / "scene.xml"
SMALL = {"size": (24, 24), "seed": 5, "method": "path"}
#: A pass takes some hundredths of a second, so that there is time to kill something.
SLOW = {"size": (96, 96), "seed": 5, "method": "path"}
DEATHS = {**SLOW, "passes": 96, "block": 16}


def render_with_report(scene, **options):
    """The image and the report."""
    reports = []
    image = render(scene, report=reports.append, **options)
    return image, reports[0]


@pytest.fixture(scope="module")
def scene():
    return ml.load_file(str(SCENE))


@contextmanager
def local(workers):
    with (
        distributed.LocalCluster(
            n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=":0", silence_logs=50
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


@pytest.fixture(scope="module")
def two():
    with local(2) as client:
        yield client


def same(image, expected):
    assert image.passes == expected.passes
    assert np.array_equal(np.asarray(image), np.asarray(expected))
    assert np.array_equal(image.variance, expected.variance)
    assert list(image.layers) == list(expected.layers)
    for name in expected.layers:
        assert np.array_equal(image.layers[name], expected.layers[name]), name


def wait_until(condition, seconds=60.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


def passes_of_attempts(folder):
    """Passes of the attempts in a folder that have not ended."""
    counts = []
    for file in Path(folder).glob("*.passes"):
        part = file.name.split(".part.")[0] + ".part"
        text = file.read_text()
        if text and not (Path(folder) / part).exists():
            counts.append(int(text))
    return counts


def in_mid_share(folder, workers=2):
    return len(passes_of_attempts(folder)) >= workers


def parts(folder):
    return sorted(Path(folder).glob("*.part"))


# Shares and rounds


def test_shares_cover_all_blocks_once():
    for blocks in (1, 7, 16, 100):
        for shares in (1, 2, 3, 16, 1000):
            pieces = cut([range(blocks)], shares)
            assert [block for piece in pieces for block in piece] == list(range(blocks))
            assert len(pieces) == min(shares, blocks)
            assert max(map(len, pieces)) - min(map(len, pieces)) <= 1
    assert cut([], 4) == []


def test_gaps_between_existing_shares():
    assert gaps(10, [range(2, 4), range(7, 8)]) == [range(0, 2), range(4, 7), range(8, 10)]
    assert gaps(3, []) == [range(0, 3)]
    assert gaps(3, [range(0, 3)]) == []
    assert disjoint([range(3, 6), range(0, 4), range(4, 5), range(0, 2)]) == [range(0, 4), range(4, 5)]
    pieces = cut(gaps(10, [range(2, 4), range(7, 8)]), 3)
    assert sorted(block for piece in pieces for block in piece) == [0, 1, 4, 5, 6, 8, 9]


def test_names_of_parts():
    assert blocks_of(part_name(range(3, 70000))) == range(3, 70000)
    for other in ("blocks-00003-00003.part", "1.part", "blocks-00000-00001.part.tmp", "render.json"):
        assert blocks_of(other) is None


def test_number_of_shares():
    assert share_count(3, 4) == 3
    assert share_count(64, 4) == 16
    assert share_count(1000, 4) == 250


def progress(**changes):
    values = {
        "blocks": 8,
        "workers": 4,
        "seconds": 10.0,
        "block_seconds": 5.0,
        "merge_seconds": 0.0,
        "relative_error": 0.1,
    }
    return Progress(**{**values, **changes})


def test_rounds_by_time():
    assert next_round(progress(blocks=0), 60, None) == 4
    assert next_round(progress(), 1000, None) == 8, "a round at most doubles"
    assert next_round(progress(), 15, None) == 4
    assert next_round(progress(), 17.4, None) == 4 and next_round(progress(), 17.6, None) == 8
    assert next_round(progress(), 12.4, None) == 0, "the next wave would end farther beyond"
    assert next_round(progress(merge_seconds=0.5), 16, None) == 0, "merging takes 4 s now, and 6 s later"
    assert next_round(progress(block_seconds=None), 11, None) == 4


def test_rounds_by_error():
    assert next_round(progress(), None, 0.1) == 0
    assert next_round(progress(), None, 0.01) == 8, "a round at most doubles"
    # 8 (0.1/0.09)² = 9.9 blocks: one wave of four.
    assert next_round(progress(), None, 0.09) == 4
    assert next_round(progress(blocks=800), None, 0.0999) == 100, "an eighth at least"
    assert next_round(progress(relative_error=float("nan")), None, 0.1) == 8
    assert next_round(progress(), 10.0, 0.01) == 0, "the time is over"


# The same bits


#: Methods with few lights and photons, which are most of the time of small images.
METHODS = {
    "rich-vpl": {"lights": 32, "photons": 1000},
    "path": {},
    "photon-map": {"photons": 1000},
    "rich-lightcuts": {"lights": 32, "photons": 1000},
}


@pytest.fixture(scope="module")
def one_run(scene):
    """Images of all methods by one run. The last block is not full."""

    def options(method):
        return {"size": (16, 16), "seed": 5, "method": method, "passes": 36, "block": 8, **METHODS[method]}

    return {method: (options(method), ml.render(scene, **options(method))) for method in METHODS}


@pytest.mark.parametrize("workers", [1, 4])
def test_same_bits_as_one_run(scene, one_run, workers, tmp_path):
    with local(workers) as client:
        for k, (method, (options, expected)) in enumerate(one_run.items()):
            folder = tmp_path / method if k % 2 else None
            image, report = render_with_report(scene, client=client, folder=folder, progress=False, **options)
            same(image, expected)
            assert report.blocks == 5 and report.repeated_blocks == 0 and report.retries == 0
            assert len(report.shares) == (4 if workers == 1 else 5)
            assert len({share.worker for share in report.shares}) == workers
            assert all(len(share.sha256) == 64 for share in report.shares)
            assert folder is None or not folder.exists(), "parts are deleted after success"


def test_without_a_cluster_this_process_renders():
    calls = []
    image = render(str(SCENE), passes=20, block=8, progress=lambda *call: calls.append(call), **SMALL)
    same(image, ml.render(ml.load_file(str(SCENE)), passes=20, block=8, **SMALL))
    assert calls[-1][:2] == (20, 20)


def test_options_that_are_not_given_are_left_out(scene):
    options = {"passes": 20, "block": 8, **SMALL}
    left_out = {"denoise": False, "preview": False, "blocks": None, "lights_out": None, "threads": None}
    same(render(scene, progress=False, **left_out, **options), ml.render(scene, **options))


def test_parts_of_an_earlier_call_are_used_and_damaged_ones_rendered_again(scene, two, tmp_path):
    options = {**SMALL, "passes": 64, "block": 8}

    def stop(passes, total, seconds):
        if len(parts(tmp_path)) >= 3:
            raise InterruptedError("enough")

    with pytest.raises(InterruptedError):
        render(scene, client=two, folder=tmp_path, shares=8, progress=stop, **options)
    # What was cancelled ends after its pass.
    time.sleep(1.0)
    found = parts(tmp_path)
    assert len(found) >= 3
    data = bytearray(found[1].read_bytes())
    data[len(data) // 2] ^= 1
    found[1].write_bytes(data)
    found[2].write_bytes(found[2].read_bytes()[:100])
    # More shares than before: what exists keeps its blocks.
    image, report = render_with_report(scene, client=two, folder=tmp_path, progress=False, **options)
    same(image, ml.render(scene, **options))
    assert report.found_blocks == len(found) - 2
    assert report.repeated_blocks >= 2, "the damaged ones"
    assert tmp_path.exists() and not list(tmp_path.iterdir())


def test_a_part_that_is_damaged_before_the_merge_is_rendered_again(scene, two, tmp_path):
    options = {**SMALL, "passes": 64}

    def spoil(passes, total, seconds):
        if passes == total and len(parts(tmp_path)) == 4 and not spoiled:
            spoiled.append(parts(tmp_path)[2])
            spoiled[0].write_bytes(b"no part")

    spoiled = []
    image, report = render_with_report(scene, client=two, folder=tmp_path, progress=spoil, **options)
    assert spoiled and report.repeated_blocks == 1
    same(image, ml.render(scene, **options))


# Deaths


@pytest.fixture(scope="module")
def undisturbed(scene):
    return ml.render(scene, **DEATHS)


def test_a_killed_worker_costs_the_passes_of_its_share(scene, undisturbed, two, tmp_path):
    pids = two.run(os.getpid)
    with ThreadPoolExecutor(1) as thread:
        call = thread.submit(render_with_report, scene, client=two, folder=tmp_path, shares=3, progress=False, **DEATHS)
        wait_until(lambda: in_mid_share(tmp_path))
        os.kill(next(iter(pids.values())), signal.SIGKILL)
        image, report = call.result(120)
    same(image, undisturbed)
    print(f"repeated: {report.repeated_passes} passes, {report.repeated_blocks} blocks")
    assert 1 <= report.repeated_blocks <= 2, "those that the killed worker had begun"
    assert report.repeated_passes < 32
    assert report.retries == 0, "Dask sends the share to another worker"


@pytest.mark.parametrize("retries", [0, 1])
def test_a_share_that_dask_gives_up(scene, tmp_path, retries):
    options = {**SLOW, "passes": 64, "block": 32}
    with dask.config.set({"distributed.scheduler.allowed-failures": 0}), local(1) as client:
        pids = client.run(os.getpid)
        with ThreadPoolExecutor(1) as thread:
            call = thread.submit(render_with_report, scene, client=client, folder=tmp_path, retries=retries, progress=False, **options)
            wait_until(lambda: in_mid_share(tmp_path, 1))
            os.kill(next(iter(pids.values())), signal.SIGKILL)
            if retries == 0:
                with pytest.raises(ml.Error, match=r"share-00\d-of-002: 1 workers died"):
                    call.result(60)
            else:
                image, report = call.result(60)
                assert report.retries == 1
                same(image, ml.render(scene, **options))


def test_a_worker_renders_one_share_at_a_time_with_all_its_threads(scene, monkeypatch):
    original, lock, running, seen = ml.render_part, threading.Lock(), set(), []

    def observed(*args, threads, **options):
        worker = distributed.get_worker().address
        with lock:
            seen.append((worker in running, threads))
            running.add(worker)
        try:
            original(*args, threads=threads, **options)
        finally:
            with lock:
                running.discard(worker)

    monkeypatch.setattr(ml, "render_part", observed)
    with distributed.Client(n_workers=2, threads_per_worker=3, processes=False, dashboard_address=":0") as client:
        render(scene, client=client, passes=64, block=8, progress=False, **SMALL)
    assert seen == [(False, 3)] * 8


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


@contextmanager
def processes():
    """Starts processes, and ends them."""
    started = []

    def start(*command, **options):
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, **options)
        started.append(process)
        return process

    try:
        yield start
    finally:
        for process in reversed(started):
            process.terminate()
        for process in started:
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def start_cluster(start, port, workers=2):
    address = f"tcp://127.0.0.1:{port}"
    dask = [sys.executable, "-m", "distributed.cli.dask_scheduler"]
    scheduler = start(*dask, "--host", "127.0.0.1", "--port", str(port), "--no-dashboard")
    worker = [sys.executable, "-m", "distributed.cli.dask_worker"]
    for _ in range(workers):
        start(*worker, address, "--nthreads", "1", "--no-dashboard", "--death-timeout", "60")
    return address, scheduler


def test_a_scheduler_that_is_started_again_in_time_goes_unnoticed(scene, undisturbed, tmp_path):
    port = free_port()
    with processes() as start:
        address, scheduler = start_cluster(start, port)
        with distributed.Client(address, timeout=30) as client, ThreadPoolExecutor(1) as thread:
            client.wait_for_workers(2, timeout=30)
            call = thread.submit(render_with_report, scene, client=client, folder=tmp_path, progress=False, **DEATHS)
            wait_until(lambda: parts(tmp_path) and in_mid_share(tmp_path, 1))
            scheduler.kill()
            scheduler.wait()
            start_cluster(start, port)
            image, report = call.result(120)
    same(image, undisturbed)
    print(f"repeated: {report.repeated_passes} passes, {report.repeated_blocks} blocks")
    assert report.repeated_blocks <= 2, "those that were under way"


def test_a_scheduler_that_stays_away_ends_the_call(scene, undisturbed, tmp_path):
    with processes() as start:
        address, scheduler = start_cluster(start, free_port())
        with distributed.Client(address, timeout=30) as client:
            client.wait_for_workers(2, timeout=30)
        with distributed.Client(address, timeout=5) as client, ThreadPoolExecutor(1) as thread:
            call = thread.submit(render, scene, client=client, folder=tmp_path, progress=False, **DEATHS)
            wait_until(lambda: parts(tmp_path) and in_mid_share(tmp_path, 1))
            scheduler.kill()
            with pytest.raises(ml.Error, match="the scheduler of the Dask client is gone.*part files"):
                call.result(60)
    image, report = render_with_report(scene, folder=tmp_path, progress=False, **DEATHS)
    same(image, undisturbed)
    assert report.found_blocks >= 1


DRIVER = f"""
import sys
import distributed
from manylight.distributed import render
address, scene, folder = sys.argv[1:]
if __name__ == "__main__":
    with distributed.Client(address, timeout=30) as client:
        render(scene, client=client, folder=folder, progress=False, **{DEATHS})
"""


@pytest.mark.parametrize("victims", ["driver", "driver and scheduler"])
def test_the_call_is_made_again_after_the_death_of_its_process(scene, undisturbed, tmp_path, victims):
    port = free_port()
    folder = tmp_path / "parts"
    with processes() as start:
        address, scheduler = start_cluster(start, port)
        driver = start(sys.executable, "-c", DRIVER, address, str(SCENE), str(folder))
        wait_until(lambda: len(parts(folder)) >= 2 and in_mid_share(folder, 1))
        driver.kill()
        driver.wait()
        if "scheduler" in victims:
            scheduler.kill()
            scheduler.wait()
            start_cluster(start, port)
        with distributed.Client(address, timeout=30) as client:
            client.wait_for_workers(2, timeout=30)
            found = len(parts(folder))
            image, report = render_with_report(scene, client=client, folder=folder, progress=False, **DEATHS)
    same(image, undisturbed)
    print(f"found {report.found_blocks}, repeated: {report.repeated_passes} passes, {report.repeated_blocks} blocks")
    assert report.found_blocks >= found >= 2
    assert report.repeated_blocks <= 2, "those that were under way"
    assert not folder.exists()


def test_an_interrupt_cancels_and_leaves_whole_files(scene, tmp_path):
    with processes() as start:
        address, _ = start_cluster(start, free_port())
        driver = start(sys.executable, "-c", DRIVER, address, str(SCENE), str(tmp_path))
        wait_until(lambda: parts(tmp_path) and in_mid_share(tmp_path, 1))
        driver.send_signal(signal.SIGINT)
        assert driver.wait(60) != 0
        with distributed.Client(address, timeout=30) as client:
            wait_until(lambda: not any(client.processing().values()), 60)
            time.sleep(1.0)
            left = {path.name: path.stat().st_mtime for path in tmp_path.iterdir()}
            time.sleep(1.0)
            assert left == {path.name: path.stat().st_mtime for path in tmp_path.iterdir()}, "workers went on"
        assert all(ml.part_info(str(path)) for path in parts(tmp_path))
        assert not list(tmp_path.glob("*.tmp")) and len(parts(tmp_path)) < 6


# Rounds


@pytest.mark.parametrize(("text", "seconds"), [("300ms", 0.3), ("90", 90), ("60s", 60), ("2min", 120), ("1.5h", 5400), (7, 7)])
def test_units_of_times_are_those_of_the_command(text, seconds):
    assert goal_of(None, text, None).time == seconds


def test_time(scene, two):
    start = time.monotonic()
    image, report = render_with_report(scene, client=two, time=5, progress=False, block=8, **SMALL)
    seconds = time.monotonic() - start
    print(f"{seconds:.2f} s, {report.passes} passes, {report.rounds} rounds")
    # The machine may do other things: how close the end is to the time is measured, not tested.
    assert report.rounds >= 1
    assert report.passes == 8 * report.blocks
    same(image, ml.render(scene, passes=report.passes, block=8, **SMALL))


def test_target_error(scene, two):
    options = {**SMALL, "block": 8}
    first = ml.render(scene, passes=16, **options).relative_error
    target = first / 3
    image, report = render_with_report(scene, client=two, target_error=target, progress=False, **options)
    print(f"{report.passes} passes, {report.rounds} rounds, {image.relative_error} <= {target}")
    assert image.relative_error <= target
    assert 3 <= report.rounds <= 8 and 16 * 3 < report.passes < 16 * 40
    same(image, ml.render(scene, passes=report.passes, **options))


def begin(scene, client, folder, **options):
    """A call that is interrupted before it has rendered anything: only the description of the render is there."""

    def stop(*_):
        raise InterruptedError

    with pytest.raises(InterruptedError):
        render(scene, client=client, folder=folder, progress=stop, **options)
    wait_until(lambda: not any(client.processing().values()))
    time.sleep(0.5)
    for path in [*Path(folder).glob("*.part"), *Path(folder).glob("*.passes")]:
        path.unlink()


def test_rounds_go_on_with_the_blocks_of_an_earlier_call(scene, two, tmp_path):
    options = {**SMALL, "block": 8}
    begin(scene, two, tmp_path, target_error="1e11%", **options)
    for blocks in (range(0, 1), range(2, 4)):
        ml.render_part(scene, str(tmp_path / part_name(blocks)), blocks=blocks, **options)
    image, report = render_with_report(scene, client=two, folder=tmp_path, target_error="1e11%", progress=False, **options)
    assert (report.blocks, report.rounds, report.found_blocks) == (4, 1, 3)
    same(image, ml.render(scene, passes=32, **options))


# What is refused


@pytest.mark.parametrize(
    "options, message",
    [
        ({"passes": 0}, "passes: found 0"),
        ({"passes": True}, "passes: found True"),
        ({"passes": 16, "time": 3}, "passes: does not go with"),
        ({"time": "soon"}, "time: found 'soon'"),
        ({"time": -1}, "time: found -1"),
        ({"target_error": 0}, "target_error: found '0.0'"),
        ({"target_error": 2}, "target_error: found '2.0'"),
        ({"target_error": [0.1]}, "target_error: found .0.1., expected a number such as"),
        ({"lights_out": "room.lights"}, "lights_out: does not go"),
        ({"block": 12}, "block: found 12"),
        ({"shares": 0}, "shares: found 0"),
        ({"retries": -1}, "retries: found -1"),
        ({"denoise": "oidn"}, "denoise: does not go"),
    ],
)
def test_settings_of_the_call(scene, options, message):
    with pytest.raises(ml.UsageError, match=message):
        render(scene, progress=False, **options)


@pytest.mark.parametrize("options", [{"method": "rich-vpls"}, {"method": "path", "kernel": "point"}])
def test_settings_of_the_method_are_refused_once_with_the_message_of_one_run(scene, two, options):
    start = time.monotonic()
    with pytest.raises(ml.UsageError) as expected:
        ml.render(scene, passes=16, **options)
    with pytest.raises(ml.UsageError) as found:
        render(scene, client=two, passes=320, progress=False, **options)
    assert str(found.value) == str(expected.value)
    assert time.monotonic() - start < 5


def test_a_folder_of_another_render(scene, two, tmp_path):
    begin(scene, two, tmp_path, passes=64, **SMALL)
    with pytest.raises(ml.UsageError, match="seed: found 5, expected 6"):
        render(scene, client=two, folder=tmp_path, passes=64, progress=False, **{**SMALL, "seed": 6})
    (tmp_path / "render.json").write_text("{")
    with pytest.raises(ml.FileError, match="render.json.*damaged"):
        render(scene, client=two, folder=tmp_path, passes=64, progress=False, **SMALL)
    (tmp_path / "render.json").unlink()
    (tmp_path / part_name(range(1))).write_bytes(b"")
    with pytest.raises(ml.UsageError, match="no render.json"):
        render(scene, client=two, folder=tmp_path, passes=64, progress=False, **SMALL)


def test_a_part_that_cannot_be_written_is_tried_again(scene, two, tmp_path):
    options = {**SMALL, "passes": 64}
    begin(scene, two, tmp_path, **options)
    blocked = tmp_path / part_name(range(1))
    (blocked / "full").mkdir(parents=True)
    with pytest.raises(ml.FileError, match=blocked.name):
        render(scene, client=two, folder=tmp_path, shares=4, retries=1, progress=False, **options)
    assert len([part for part in parts(tmp_path) if part.is_file()]) == 3, "the others were rendered meanwhile"
    with ThreadPoolExecutor(1) as thread:
        call = thread.submit(render_with_report, scene, client=two, folder=tmp_path, shares=4, retries=4, progress=False, **options)
        time.sleep(0.3)
        (blocked / "full").rmdir()
        blocked.rmdir()
        image, report = call.result(60)
    assert report.retries >= 1
    same(image, ml.render(scene, **options))


def answers(**changes):
    common = {"version": ml.__version__, "instruction_set": "avx2", "host": "a", "sees_folder": True}
    return {"tcp://a:1": common, "tcp://b:2": {**common, "host": "b", **changes}}


def test_a_worker_that_leaves_while_it_is_asked_is_asked_again(two, tmp_path, monkeypatch):
    run = distributed.Client.run
    asked = []

    def run_closed_once(client, *args, **options):
        found = run(client, *args, **options)
        asked.append(dict(found))
        if len(asked) == 1:
            found[next(iter(found))] = distributed.comm.CommClosedError("closed")
        return found

    monkeypatch.setattr(distributed.Client, "run", run_closed_once)
    Cluster(two, Folder(tmp_path, {}), "topic", lambda message: None).close()
    assert [len(answers) for answers in asked] == [2, 2]


def test_workers_that_differ(tmp_path):
    folder = Folder(tmp_path, {})
    assert check_workers(answers(), folder)["instruction_set"] == "avx2"
    with pytest.raises(ml.UsageError, match="avx2: tcp://a:1 on a; avx512: tcp://b:2 on b"):
        check_workers(answers(instruction_set="avx512"), folder)
    with pytest.raises(ml.UsageError, match="0.0.1: tcp://b:2 on b") as error:
        check_workers(answers(version="0.0.1"), folder)
    assert "this process" in str(error.value)
    with pytest.raises(ml.UsageError, match="tcp://b:2 on b do not see"):
        check_workers(answers(sees_folder=False), folder)
    with pytest.raises(ml.UsageError, match="tcp://b:2 cannot import manylight.distributed"):
        check_workers({**answers(), "tcp://b:2": Exception("ModuleNotFoundError(\"No module named 'manylight'\")")}, folder)
