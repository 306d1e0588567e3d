"""What a results folder keeps of each job, and how it reads what a kill or a disk has left."""

import gzip
import json
import shutil
from dataclasses import asdict, dataclass, replace

import pytest
import toy_study
from toy_study import JOB_COUNT, SELECTION, STUDY, SumRow, left_by, run_toy

from experiments.study import files, rows
from experiments.study.folder import ResultsFolder, error_path, read_entries, read_results
from experiments.study.manifest import jobs_of
from experiments.study.run import Work
from experiments.study.study import Result

JOBS = jobs_of(STUDY, [SELECTION], None)


class Killed(BaseException):
    """The process ends here; nobody but the kernel notices."""


def result_of(job):
    ((_, result),) = Work(STUDY)((job,))
    return replace(result, wall_s=0.5)


def journal_of(jobs):
    """The lines that these jobs leave in a journal."""

    def line(job):
        key, result = STUDY.key_of(job), result_of(job)
        text = "".join(map(rows.row_line, result.rows))
        timings = rows.csv_line([*key, 0.5])
        return {"key": key, "rows": text, "timings": timings, "curves": result.curves}

    return "".join(json.dumps(line(job)) + "\n" for job in jobs)


def test_rows_timings_and_curves_stand_in_the_order_of_the_jobs(tmp_path):
    for name, order in (("x", JOBS), ("y", JOBS[::-1])):
        (tmp_path / name).mkdir()
        folder = ResultsFolder(tmp_path / name, STUDY, JOBS)
        for job in order:
            folder.add(job, result_of(job))
        folder.close()
    assert left_by(tmp_path / "x") == left_by(tmp_path / "y")
    results = read_results(tmp_path / "y", STUDY)
    assert [(row.method, row.seed, row.part) for row in results.rows] == [
        (job.method, job.seed, part) for job in JOBS for part in ("half", "whole")
    ]
    keys = [STUDY.key_of(job) for job in JOBS]
    assert list(results.curves["curves"]) == keys
    assert toy_study.timed_jobs(tmp_path / "y") == [",".join(key) for key in keys]
    text = gzip.decompress((tmp_path / "y" / "curves.csv.gz").read_bytes()).decode()
    assert text.splitlines()[:2] == ["method,seed,step,height", "pf,0,0,0"]


def test_what_is_added_is_safe_before_the_folder_is_closed(tmp_path):
    folder = ResultsFolder(tmp_path, STUDY, JOBS)
    folder.add(JOBS[3], result_of(JOBS[3]))
    del folder
    again = ResultsFolder(tmp_path, STUDY, JOBS)
    assert again.missing(JOBS) == [job for job in JOBS if job != JOBS[3]]
    assert not (tmp_path / "journal.jsonl").exists()
    assert [row.part for row in again.rows_of(JOBS[3])] == ["half", "whole"]
    assert isinstance(again.rows_of(JOBS[3])[0], SumRow)
    assert again.mean_wall_s == 0.5


def test_a_journal_torn_at_any_byte_costs_the_job_that_was_being_written(tmp_path):
    """Beside the files of an earlier run, which it is newer than."""
    short = [job for job in JOBS if job.seed < 2]
    run_toy(tmp_path / "short", SELECTION | {"seeds": [0, 1]})
    text = journal_of(JOBS[4:6]).encode()
    for cut in range(0, len(text) + 1, 23):
        folder = shutil.copytree(tmp_path / "short", tmp_path / f"torn{cut}")
        (folder / "journal.jsonl").write_bytes(text[:cut])
        left = JOBS[4 : 4 + text[:cut].count(b"\n")]
        assert ResultsFolder(folder, STUDY, JOBS).missing(JOBS) == [
            job for job in JOBS if job not in (*short, *left)
        ]
        assert not (folder / "journal.jsonl").exists()


@pytest.mark.parametrize("moment", range(1, 8))
def test_a_kill_at_any_moment_of_putting_the_files_in_order_loses_nothing(
    tmp_path, monkeypatch, moment
):
    """Seven steps: three files are written and put in place, then the journal is removed."""
    run_toy(tmp_path / "toy", SELECTION | {"seeds": [0, 1]})
    (tmp_path / "toy" / "journal.jsonl").write_text(journal_of(JOBS[4:]))
    steps = iter(range(1, 100))

    def dying(step):
        def do(*arguments, **flags):
            if next(steps) == moment:
                raise Killed
            return step(*arguments, **flags)

        return do

    monkeypatch.setattr(files.os, "fsync", dying(files.os.fsync))
    monkeypatch.setattr(files.os, "replace", dying(files.os.replace))
    monkeypatch.setattr("pathlib.Path.unlink", dying(files.Path.unlink))
    with pytest.raises(Killed):
        ResultsFolder(tmp_path / "toy", STUDY, JOBS)
    monkeypatch.undo()
    assert len(read_results(tmp_path / "toy", STUDY).rows) == 2 * JOB_COUNT
    assert ResultsFolder(tmp_path / "toy", STUDY, JOBS).missing(JOBS) == []
    assert len(toy_study.timed_jobs(tmp_path / "toy")) == JOB_COUNT


def test_a_folder_that_is_written_to_can_be_read(tmp_path):
    """The files are those of the last run, the newest line of the journal is torn."""
    run_toy(tmp_path, SELECTION | {"seeds": [0]})
    text = journal_of(JOBS[2:4])
    (tmp_path / "journal.jsonl").write_text(text[:-9])
    before = {path: path.read_bytes() for path in tmp_path.iterdir() if path.is_file()}
    results = read_results(tmp_path, STUDY)
    assert [(row.method, row.seed) for row in results.rows[::2]] == [
        ("pf", 0),
        ("igpf", 0),
        ("pf", 1),
    ]
    assert len(results.curves["curves"]) == 3
    assert {path: path.read_bytes() for path in tmp_path.iterdir() if path.is_file()} == before


def test_a_folder_without_a_row_is_said_to_hold_none(tmp_path):
    with pytest.raises(ValueError, match=rf"{tmp_path} holds no finished sum yet"):
        read_results(tmp_path, STUDY)
    ResultsFolder(tmp_path, STUDY, JOBS)
    with pytest.raises(ValueError, match=rf"{tmp_path} holds no finished sum yet"):
        read_results(tmp_path, STUDY)


def test_the_rows_of_jobs_that_crashed_are_told_apart(tmp_path, monkeypatch):
    monkeypatch.setenv("TOY_CRASH_SEEDS", "2,4")
    run_toy(tmp_path)
    results = read_results(tmp_path, STUDY)
    assert len(results.good) == len(results.rows) - 4 == 2 * (JOB_COUNT - 4)
    assert results.notes == ["left out: 4 that crashed; the same command tries them again"]


@pytest.mark.parametrize("name", ["rows.csv", "timings.csv", "curves.csv.gz"])
def test_columns_of_another_version_are_refused(copy, name):
    path = copy / name
    data = path.read_bytes()
    text = (gzip.decompress(data) if name.endswith("gz") else data).decode()
    text = text.replace("seed,", "seeds,", 1)
    path.write_bytes(gzip.compress(text.encode()) if name.endswith("gz") else text.encode())
    message = rf"{name} has the columns of another version of beltgrasp; choose another folder"
    with pytest.raises(ValueError, match=message):
        read_entries(copy, STUDY)


@pytest.mark.parametrize("damage", [lambda data: data[:-5], lambda data: b"no gzip"])
def test_a_damaged_file_of_curves_is_named(copy, unbroken, damage):
    (copy / "curves.csv.gz").write_bytes(damage(unbroken["curves.csv.gz"]))
    with pytest.raises(ValueError, match=r"curves\.csv\.gz is damaged"):
        read_entries(copy, STUDY)


@pytest.mark.parametrize("name", ["timings.csv", "curves.csv.gz"])
def test_a_file_that_lacks_beside_the_rows_is_not_written_anew_without_them(copy, name):
    (copy / name).write_bytes(b"")
    message = rf"{name} is missing beside rows\.csv; put it back, or choose another folder"
    for _ in range(2):
        with pytest.raises(ValueError, match=message):
            ResultsFolder(copy, STUDY, JOBS)
        (copy / name).unlink(missing_ok=True)
    assert not (copy / name).exists()


def test_a_row_of_none_of_the_jobs_is_refused(copy, unbroken):
    message = rf"{copy} holds a row of another selection, igpf 0; choose another folder"
    with pytest.raises(ValueError, match=message):
        ResultsFolder(copy, STUDY, [job for job in JOBS if job.method == "pf"])
    assert left_by(copy) == unbroken


def test_tracebacks_of_a_job_are_kept_one_after_the_other(tmp_path):
    folder, job = ResultsFolder(tmp_path, STUDY, JOBS), JOBS[0]
    for number in (1, 2):
        row = rows.error_row(SumRow, STUDY.identity(job), "broke")
        folder.add(job, Result((row,), error=f"Traceback {number}: no file \udcff\n"))
    path = error_path(tmp_path, STUDY.key_of(job))
    assert path == tmp_path / "errors" / "pf_0.txt"
    one, two = (f"Traceback {number}: no file \\udcff\n" for number in (1, 2))
    assert path.read_text() == f"{one}\n{two}"
    assert folder.counts(JOBS) == (0, 1)
    assert folder.missing(JOBS) == JOBS
    assert folder.missing(JOBS, retry=False) == JOBS[1:]


def test_the_file_of_a_traceback_is_named_after_the_job_whatever_its_name(tmp_path):
    path = error_path(tmp_path, ("my.mod:Tracker", "a/b", "0"))
    assert path == tmp_path / "errors" / "my.mod.Tracker_a.b_0.txt"


@dataclass(frozen=True)
class SumTimings:
    method: str
    seed: int
    half_ms: float | None
    wall_s: float


def test_a_study_with_timings_of_its_own_has_them_typed(tmp_path):
    study = replace(STUDY, timings=SumTimings)
    folder = ResultsFolder(tmp_path, study, JOBS)
    for job in JOBS[:2]:
        timings = SumTimings(job.method, job.seed, 1.5, 2.0)
        folder.add(job, replace(result_of(job), timings=timings))
    folder.close()
    assert read_results(tmp_path, study).timings == [
        SumTimings("pf", 0, 1.5, 2.0),
        SumTimings("igpf", 0, 1.5, 2.0),
    ]
    assert folder.mean_wall_s == 2.0
    assert asdict(folder.rows_of(JOBS[0])[0])["outcome"] == "done"
