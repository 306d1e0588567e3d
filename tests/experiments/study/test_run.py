"""Runs of the toy that are killed, stopped, crash, meet a full disk, and go on."""

import json
import os
import resource
import shutil
import signal
import stat
import time
from dataclasses import replace

import numpy as np
import pytest
import toy_study
from toy_study import JOB_COUNT, LONG, LONG_COUNT, SELECTION, STUDY, left_by, run_toy

from experiments.study import files
from experiments.study.files import exclusive, whole_lines
from experiments.study.folder import read_entries, read_results
from experiments.study.manifest import Manifest
from experiments.study.processes import LocalWorkers
from experiments.study.run import Interrupted, batches, crashed, keep
from experiments.study.shard import Shard


def rows_in(folder):
    return read_results(folder, STUDY).rows


def outcomes(folder):
    return [row.outcome for row in rows_in(folder) if row.part != "half"]


class Killed(BaseException):
    """The process ends here."""


def test_a_run_has_the_rows_of_each_job_in_order_and_a_time_for_each(finished):
    assert [(row.seed, row.method, row.part) for row in rows_in(finished)] == [
        (seed, method, part)
        for seed in range(6)
        for method in ("pf", "igpf")
        for part in ("half", "whole")
    ]
    assert toy_study.timed_jobs(finished) == [
        f"{method},{seed}" for seed in range(6) for method in ("pf", "igpf")
    ]
    assert (finished / "notes" / "igpf" / "5.txt").read_text() == "igpf, seed 5\n"


def test_two_workers_leave_the_bytes_of_one_even_out_of_order(
    tmp_path, unbroken, monkeypatch, capfd
):
    monkeypatch.setenv("TOY_SLOW_ONCE", str(tmp_path / "slow_once"))
    monkeypatch.setenv("TOY_SLOW_S", "0.5")
    monkeypatch.setenv("TOY_KILL_ONCE", str(tmp_path / "killed_once"))
    done = run_toy(tmp_path / "two", workers=2)
    assert left_by(tmp_path / "two") == unbroken
    assert (tmp_path / "killed_once").exists(), "a worker was to die and be replaced"
    assert (done.job_count, done.error_count) == (JOB_COUNT, 0)
    text = capfd.readouterr().err
    assert "toy/sums: 12 sums; 2 workers\n" in text
    assert f"failures {JOB_COUNT // 2}" in text


def test_this_process_leaves_the_bytes_of_a_worker(tmp_path, unbroken):
    run_toy(tmp_path / "here")
    assert left_by(tmp_path / "here") == unbroken


@pytest.mark.parametrize("workers", [1, 2])
def test_killed_twice_and_run_again_leaves_the_bytes_of_an_unbroken_run(
    tmp_path, unbroken, workers
):
    folder = tmp_path / "killed"
    for _ in range(2):
        wanted = toy_study.job_count(folder) + 3
        process = toy_study.start(folder, workers, TOY_SLEEP_S="0.2")
        toy_study.wait_for_jobs(folder, process, wanted)
        toy_study.kill_group(process)
        assert process.returncode == -signal.SIGKILL
    assert 0 < toy_study.job_count(folder) < JOB_COUNT
    run_toy(folder, workers=workers)
    assert left_by(folder) == unbroken
    assert len(Manifest.read(folder).sessions) == 3


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_twenty_kills_of_coordinator_and_workers_change_no_byte(tmp_path, long_unbroken, workers):
    folder = tmp_path / "killed"

    def begin():
        return toy_study.start(folder, workers, selection=LONG, TOY_SLEEP_S="0.1")

    rng = np.random.default_rng(workers)
    kills = toy_study.kill_at_random(folder, begin, toy_study.children_of, 20, rng)
    assert min(kills) > 0
    assert 0 < toy_study.job_count(folder) < LONG_COUNT
    run_toy(folder, LONG, workers=workers)
    assert left_by(folder) == long_unbroken
    assert len(toy_study.timed_jobs(folder)) == LONG_COUNT


def test_a_kill_at_every_write_of_a_run_changes_no_byte(tmp_path, monkeypatch):
    """At the n-th step to the disk, then early in the next run as well."""
    selection = SELECTION | {"seeds": [0, 1]}
    run_toy(tmp_path / "whole", selection)
    whole, moment, was_killed = left_by(tmp_path / "whole"), 0, True
    while was_killed:
        moment += 1
        folder = tmp_path / str(moment)
        was_killed = _run_killed_at(moment, folder, selection, monkeypatch)
        _run_killed_at(1 + moment % 5, folder, selection, monkeypatch)
        run_toy(folder, selection)
        assert left_by(folder) == whole, moment
        assert toy_study.timed_jobs(folder) == toy_study.timed_jobs(tmp_path / "whole")
    assert moment > 20


def _run_killed_at(moment, folder, selection, monkeypatch):
    """Whether the run was killed before it came to its end."""
    step_count = 0

    def dying(step):
        def do(*arguments, **flags):
            nonlocal step_count
            step_count += 1
            if step_count == moment:
                raise Killed
            return step(*arguments, **flags)

        return do

    with monkeypatch.context() as patch:
        patch.setattr(files.os, "fsync", dying(files.os.fsync))
        patch.setattr(files.os, "replace", dying(files.os.replace))
        patch.setattr("pathlib.Path.unlink", dying(files.Path.unlink))
        try:
            run_toy(folder, selection)
        except Killed:
            return True
    return False


def test_jobs_that_ended_before_their_turn_survive_a_kill(tmp_path, unbroken):
    folder, journal = tmp_path / "killed", tmp_path / "killed" / "journal.jsonl"
    settings = {"TOY_SLOW_ONCE": str(tmp_path / "slow_once"), "TOY_SLOW_S": "600"}
    process = toy_study.start(folder, 2, **settings)
    while not whole_lines(journal) and process.poll() is None:
        time.sleep(0.005)
    toy_study.kill_group(process)
    kept = whole_lines(journal)
    assert kept
    with journal.open("a") as file:
        file.write('{"key": ["igpf", "5"], "ro')
    run_toy(folder, workers=2)
    assert left_by(folder) == unbroken
    assert json.loads(kept[0])["timings"] in (folder / "timings.csv").read_text()


@pytest.mark.parametrize("line_count", [0, 1, 3, 23])
@pytest.mark.parametrize("torn", ["", "pf,1,ha"])
def test_rows_that_were_cut_off_are_run_again(copy, unbroken, line_count, torn):
    path = copy / "rows.csv"
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:line_count]) + torn)
    run_toy(copy)
    assert left_by(copy) == unbroken
    assert len(toy_study.timed_jobs(copy)) == JOB_COUNT


def test_a_finished_run_runs_nothing_again(copy, unbroken, monkeypatch):
    monkeypatch.setenv("TOY_CRASH_SEEDS", "0,1,2,3,4,5")
    timings = (copy / "timings.csv").read_bytes()
    assert run_toy(copy, workers=2).error_count == 0
    assert left_by(copy) == unbroken
    assert (copy / "timings.csv").read_bytes() == timings


class TestGrowth:
    """A folder holds all that was ever asked for."""

    def test_a_selection_that_holds_an_earlier_one_leaves_the_bytes_of_itself_alone(
        self, tmp_path, unbroken
    ):
        for change in ({"seeds": [2, 3]}, {"methods": ["igpf"], "seeds": [5]}, {}):
            run_toy(tmp_path, SELECTION | change)
        assert left_by(tmp_path) == unbroken
        assert Manifest.read(tmp_path).selections == [SELECTION]

    def test_seeds_that_are_added_leave_the_bytes_of_one_run(self, tmp_path, unbroken):
        for seeds in ([3, 4, 5], [0, 1, 2]):
            done = run_toy(tmp_path, SELECTION | {"seeds": seeds})
            assert done.job_count == JOB_COUNT // 2
        assert left_by(tmp_path) == unbroken

    def test_the_bytes_do_not_depend_on_which_selection_was_run_first(self, tmp_path):
        """The rows of a seed stand side by side, whichever method came first."""
        methods = ["pf", "igpf", "gpf"]
        for name, order in (("x", methods), ("y", methods[::-1])):
            for method in order:
                run_toy(tmp_path / name, SELECTION | {"methods": [method]})
        assert left_by(tmp_path / "x") == left_by(tmp_path / "y")

    def test_all_at_once_after_each_alone_leaves_the_bytes_of_all_at_once(self, tmp_path, unbroken):
        for methods in (["pf"], ["igpf"], ["pf", "igpf"]):
            run_toy(tmp_path, SELECTION | {"methods": methods})
        assert left_by(tmp_path) == unbroken

    def test_a_part_of_what_is_there_adds_nothing(self, copy, unbroken, capfd):
        done = run_toy(copy, SELECTION | {"methods": ["igpf"]})
        assert done.job_count == JOB_COUNT // 2
        assert "toy/sums: 6 sums, 6 of them done; " in capfd.readouterr().err
        assert left_by(copy) == unbroken

    def test_a_result_is_kept_beside_others_and_in_place_of_an_older_one(self, tmp_path):
        for seed, value in ((1, 0.5), (0, 2.5), (1, 1.5)):
            job = toy_study.Sum("pf", seed)
            row = toy_study.SumRow("pf", seed, "whole", "done", value)
            result = replace(toy_study.add(job), rows=(row,))
            keep(STUDY, {"methods": ["pf"], "seeds": [seed]}, tmp_path, job, result)
        assert [(row.seed, row.value) for row in rows_in(tmp_path)] == [(0, 2.5), (1, 1.5)]
        assert all("ended_utc" in session for session in Manifest.read(tmp_path).sessions)

    def test_a_crash_does_not_take_the_place_of_a_good_result(self, copy, unbroken):
        job = toy_study.Sum("pf", 1)
        ((_, crash),) = crashed(STUDY, [job], 0.1, "broke", "Traceback")
        keep(STUDY, {"methods": ["pf"], "seeds": [1]}, copy, job, crash)
        assert left_by(copy) == unbroken


class TestCrash:
    """What raises or kills its worker is a row, and is tried again."""

    def test_a_crash_is_a_row_and_its_traceback_is_kept(self, tmp_path, monkeypatch, capfd):
        monkeypatch.setenv("TOY_CRASH_SEEDS", "2")
        monkeypatch.setenv("TOY_DEADLY_SEEDS", "3")
        done = run_toy(tmp_path, SELECTION | {"methods": ["pf"]}, workers=2)
        assert outcomes(tmp_path) == ["done", "done", "error", "error", "done", "done"]
        assert done.error_count == 2
        crashed, died = (row for row in rows_in(tmp_path) if row.outcome == "error")
        assert (crashed.method, crashed.seed, crashed.value) == ("pf", 2, None)
        assert crashed.detail == "ZeroDivisionError: the toy broke, on purpose"
        text = (tmp_path / "errors" / "pf_2.txt").read_text()
        assert text.startswith("Traceback (most recent call last)")
        assert "ZeroDivisionError: the toy broke" in text
        assert died.detail == "worker process died 3 times, the last time by SIGKILL"
        assert (tmp_path / "errors" / "pf_3.txt").read_text() == died.detail + "\n"
        lines = capfd.readouterr().err
        reason = "ZeroDivisionError: the toy broke, on purpose"
        assert f"beltgrasp: error: pf, seed 2: {reason}\n" in lines
        assert f"beltgrasp: error: pf, seed 3: {died.detail}\n" in lines

    def test_it_counts_as_an_error_and_not_as_a_failure(self, tmp_path, monkeypatch, capfd):
        """Also where the study takes any row without a value for one."""
        monkeypatch.setenv("TOY_CRASH_SEEDS", "1")
        done = run_toy(tmp_path, SELECTION | {"methods": ["pf"]})
        assert (done.failure_count, done.error_count) == (2, 1)
        assert "failures 2, errors 1" in capfd.readouterr().err

    def test_it_is_tried_again_and_leaves_the_bytes_of_an_unbroken_run(
        self, tmp_path, unbroken, monkeypatch
    ):
        monkeypatch.setenv("TOY_CRASH_SEEDS", "2")
        assert run_toy(tmp_path).error_count == 2
        monkeypatch.delenv("TOY_CRASH_SEEDS")
        assert run_toy(tmp_path).error_count == 0
        assert left_by(tmp_path) == unbroken
        assert "on purpose" in (tmp_path / "errors" / "pf_2.txt").read_text()

    def test_one_that_crashes_twice_keeps_both_tracebacks(self, tmp_path, monkeypatch):
        monkeypatch.setenv("TOY_CRASH_SEEDS", "2")
        for message in ("first", "second"):
            monkeypatch.setenv("TOY_CRASH_MESSAGE", message)
            assert run_toy(tmp_path).error_count == 2
        text = (tmp_path / "errors" / "pf_2.txt").read_text()
        assert text.count("Traceback (most recent call last)") == 2
        assert text.index("ZeroDivisionError: first") < text.index("ZeroDivisionError: second")
        assert {row.detail for row in rows_in(tmp_path)} >= {"ZeroDivisionError: second"}

    def test_it_is_left_alone_where_that_is_asked_for(self, tmp_path, monkeypatch):
        monkeypatch.setenv("TOY_CRASH_SEEDS", "2")
        run_toy(tmp_path)
        before = left_by(tmp_path)
        monkeypatch.delenv("TOY_CRASH_SEEDS")
        assert run_toy(tmp_path, retry="none").error_count == 2
        assert left_by(tmp_path) == before

    def test_a_message_that_is_no_text_is_a_row(self, tmp_path, monkeypatch):
        monkeypatch.setenv("TOY_CRASH_SEEDS", "2")
        monkeypatch.setenv("TOY_CRASH_MESSAGE", "no file \udcff")
        assert run_toy(tmp_path, workers=1).error_count == 2
        (detail,) = {row.detail for row in rows_in(tmp_path) if row.outcome == "error"}
        assert detail == "ZeroDivisionError: no file \\udcff"
        texts = [path.read_text() for path in (tmp_path / "errors").iterdir()]
        assert all(text.endswith("ZeroDivisionError: no file \\udcff\n") for text in texts)

    def test_a_result_that_is_not_of_its_job_is_a_crash(self, tmp_path, monkeypatch):
        for work, detail in (
            (of_others, "sum igpf 0 returned a row of other 0"),
            (of_lists, "a cell holds one scalar, got list"),
            (of_nothing, "zip() argument 2 is shorter than argument 1"),
        ):
            monkeypatch.setattr(toy_study, "run_sums", work)
            assert run_toy(tmp_path).error_count == JOB_COUNT
            assert detail in rows_in(tmp_path)[1].detail


def of_others(jobs):
    results = [toy_study.add(job) for job in jobs]
    return [replace(r, rows=tuple(replace(row, method="other") for row in r.rows)) for r in results]


def of_lists(jobs):
    results = [toy_study.add(job) for job in jobs]
    return [replace(r, rows=tuple(replace(row, detail=[]) for row in r.rows)) for r in results]


def of_nothing(jobs):
    return []


class TestTogether:
    """Jobs that are run at once leave what they leave alone."""

    study = replace(STUDY, together=toy_study.seed_of)

    def test_their_batches_have_those_that_belong_together(self):
        jobs = STUDY.jobs(SELECTION)
        found = batches(self.study, jobs)
        assert [[job.method for job in batch] for batch in found] == [["pf", "igpf"]] * 6
        assert batches(STUDY, jobs) == [(job,) for job in jobs]
        lone = replace(STUDY, together=lambda job: None if job.seed else "zero")
        assert [len(batch) for batch in batches(lone, jobs)] == [2, *[1] * 10]

    def test_they_leave_the_bytes_of_each_alone_and_crash_together(
        self, tmp_path, unbroken, monkeypatch
    ):
        run_toy(tmp_path / "whole", study=self.study)
        assert left_by(tmp_path / "whole") == unbroken
        monkeypatch.setenv("TOY_CRASH_SEEDS", "2")
        monkeypatch.setenv("TOY_DEADLY_SEEDS", "3")
        done = run_toy(tmp_path / "crashed", study=self.study, workers=1)
        assert done.error_count == 4
        assert len(list((tmp_path / "crashed" / "errors").iterdir())) == 4


def test_ctrl_c_keeps_what_is_finished(tmp_path, unbroken, monkeypatch):
    folder = tmp_path / "stopped"

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("experiments.study.run._running_counts", interrupt)
    message = rf"stopped; 1 of 12 are kept in {folder}$"
    with pytest.raises(Interrupted, match=message):
        run_toy(folder, workers=1)
    monkeypatch.undo()
    assert len(rows_in(folder)) == 2
    assert not (folder / "journal.jsonl").exists()
    run_toy(folder)
    assert left_by(folder) == unbroken


class TestRefused:
    """What does not belong into a folder is said in one line, and the folder is left alone."""

    @pytest.mark.parametrize(
        ("changes", "shard", "message"),
        [
            ({"name": "toy/others"}, None, "holds results of toy/sums, not of toy/others; choose"),
            (
                {"settings": lambda job: {f"method {job.method}": {"gain": 2.0}}},
                None,
                r"holds results with other settings: method pf\.gain was 1\.0, is 2\.0; method ",
            ),
            ({}, Shard(1, 2), "holds the whole of toy/sums, not shard 1/2; choose another folder"),
        ],
    )
    def test_another_study_other_settings_and_another_part(
        self, copy, unbroken, changes, shard, message
    ):
        manifest = (copy / "manifest.json").read_bytes()
        with pytest.raises(ValueError, match=f"^{copy} {message}") as refusal:
            run_toy(copy, study=replace(STUDY, **changes), shard=shard)
        assert "\n" not in str(refusal.value)
        assert (copy / "manifest.json").read_bytes() == manifest
        assert left_by(copy) == unbroken

    @pytest.mark.parametrize("manifest", ['{"preset": "loop"}', '{"root": "../x"}', "[]"])
    def test_an_earlier_version(self, tmp_path, manifest):
        (tmp_path / "manifest.json").write_text(manifest)
        (tmp_path / "trials.csv").write_text("a\n")
        with pytest.raises(ValueError, match=r"of an earlier version .* not read; choose another"):
            run_toy(tmp_path)
        assert (tmp_path / "manifest.json").read_text() == manifest
        assert not (tmp_path / "rows.csv").exists()

    def test_results_without_a_manifest(self, tmp_path):
        (tmp_path / "mine.csv").write_text("mine\n")
        message = rf"{tmp_path} holds results without their manifest\.json; choose another folder"
        with pytest.raises(ValueError, match=message):
            run_toy(tmp_path)
        assert {path.name for path in tmp_path.iterdir()} <= {"mine.csv", ".lock"}

    def test_a_second_writer(self, copy, unbroken):
        with exclusive(copy), pytest.raises(ValueError, match=f"another run is writing to {copy}"):
            run_toy(copy)
        assert left_by(copy) == unbroken

    def test_a_selection_of_nothing_and_no_workers(self, tmp_path):
        with pytest.raises(ValueError, match="toy/sums: the selection has no sum"):
            run_toy(tmp_path / "new", SELECTION | {"seeds": []})
        assert not (tmp_path / "new").exists()
        with pytest.raises(ValueError, match="workers must be 1 or greater, got 0"):
            LocalWorkers(0)


def end(process):
    """Exit code and the last line of stderr, after the progress bar."""
    text = process.communicate(timeout=60)[1]
    assert "Traceback" not in text
    return process.returncode, text.splitlines()[-1]


def fills_up_at(byte_count):
    """Lets no file grow beyond that, which ends a write as a full disk does: by half."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (byte_count, byte_count))


def obeying_permissions():
    """What to put before a command so that root, too, may write only where permissions say so."""
    if os.geteuid() != 0:
        return ()
    if shutil.which("setpriv") is None:
        pytest.skip("root writes to read-only folders, and setpriv is not there to prevent it")
    return ("setpriv", "--bounding-set=-dac_override", "--inh-caps=-dac_override")


@pytest.fixture
def read_only():
    """Makes a folder and its files read-only until the test is over."""
    changed = []

    def close(folder):
        for path in (folder, *folder.rglob("*")):
            changed.append((path, path.stat().st_mode))
            path.chmod(stat.S_IMODE(path.stat().st_mode) & ~0o222)

    yield close
    for path, mode in changed:
        path.chmod(stat.S_IMODE(mode))


class TestDisk:
    """What the disk refuses costs one line and nothing that is finished."""

    @pytest.mark.parametrize("workers", [1, 2])
    def test_one_that_fills_up(self, tmp_path, unbroken, workers):
        folder = tmp_path / "full"
        code, line = end(toy_study.start(folder, workers, prepare=fills_up_at(1500)))
        assert code == 1
        kept = read_entries(folder, STUDY)
        assert 2 < len(kept) < JOB_COUNT
        assert line == (
            f"cannot write {folder / 'journal.jsonl'}: File too large; {len(kept)} of 12 are kept "
            f"in {folder}, and the same command resumes"
        )
        timings = [entry.timings for entry in kept.values()]
        run_toy(folder)
        assert left_by(folder) == unbroken
        assert all(line in (folder / "timings.csv").read_text() for line in timings)

    def test_one_that_is_full_from_the_start(self, tmp_path):
        folder = tmp_path / "full"
        code, line = end(toy_study.start(folder, 1, prepare=fills_up_at(100)))
        assert (code, line) == (1, f"cannot write {folder / 'manifest.json'}: File too large")

    def test_a_folder_that_turns_read_only(self, copy, read_only, unbroken):
        read_only(copy)
        code, line = end(toy_study.start(copy, 1, wrapper=obeying_permissions()))
        assert (code, line) == (1, f"cannot write to {copy}: Permission denied")
        assert left_by(copy) == unbroken

    def test_a_folder_in_which_nothing_new_can_be_put(self, copy, read_only, unbroken):
        lines = unbroken["rows.csv"].splitlines(keepends=True)
        (copy / "rows.csv").write_bytes(b"".join(lines[:9]))
        read_only(copy)
        (copy / ".lock").chmod(0o644)
        code, line = end(toy_study.start(copy, 1, wrapper=obeying_permissions()))
        assert (code, line) == (1, f"cannot write {copy / 'manifest.json'}: Permission denied")
        assert (copy / "rows.csv").read_bytes() == b"".join(lines[:9])


def test_the_manifest_says_what_was_asked_for_with_which_settings_and_what_ran_where(finished):
    content = json.loads((finished / "manifest.json").read_text())
    assert content["study"] == "toy/sums"
    assert content["selections"] == [SELECTION]
    assert content["settings"] == {f"method {name}": {"gain": "1.0"} for name in ("pf", "igpf")}
    (session,) = content["sessions"]
    assert session["workers"] == 1
    assert session["packages"]["mujoco"].startswith("3.")
    assert {"commit", "is_dirty", "command", "python", "platform", "cpu"} <= set(session)
    assert session["ended_utc"] >= session["started_utc"]


def test_a_run_that_is_stopped_has_no_end(copy, monkeypatch):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("experiments.study.run._running_counts", interrupt)
    with pytest.raises(Interrupted):
        run_toy(copy, SELECTION | {"seeds": [8, 9]})
    assert "ended_utc" not in Manifest.read(copy).sessions[-1]


def test_how_long_it_may_take_is_told_where_jobs_have_been_timed(copy, capfd):
    lines = (copy / "timings.csv").read_text().splitlines()
    timed = [line.rpartition(",")[0] + ",600.0" for line in lines[1:]]
    (copy / "timings.csv").write_text("\n".join([lines[0], *timed]) + "\n")
    run_toy(copy, SELECTION | {"seeds": [*range(12)]})
    text = capfd.readouterr().err
    assert (
        "toy/sums: 24 sums, 12 of them done; 1 worker, about 2.0 h (6e+02 s a sum, as timed here)"
        in text
    )
