"""What the disk refuses costs one line and nothing that is finished."""

import os
import resource
import shutil
import stat

import pytest
import toy_sweep
from experiments.belt.sweep import run_sweep
from experiments.study.results_folder import exclusive, read_lines
from toy_sweep import PRESET, left_by

from experiments.belt.config import TrialResult
from experiments.study import records
from experiments.study.processes import LocalWorkers


def run(folder):
    return run_sweep(PRESET, folder, LocalWorkers(1), run_trial=toy_sweep.TOY)


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
        return []
    if shutil.which("setpriv") is None:
        pytest.skip("root writes to read-only folders, and setpriv is not there to prevent it")
    return ["setpriv", "--bounding-set=-dac_override", "--inh-caps=-dac_override"]


@pytest.fixture
def read_only(tmp_path):
    """Makes a folder and its files read-only until the test is over."""
    changed = []

    def close(folder):
        for path in (folder, *folder.iterdir()):
            changed.append((path, path.stat().st_mode))
            path.chmod(stat.S_IMODE(path.stat().st_mode) & ~0o222)

    yield close
    for path, mode in changed:
        path.chmod(stat.S_IMODE(mode))


@pytest.mark.parametrize(("samples", "name"), [("10", "trials.csv"), ("100", "curves.csv.gz")])
def test_a_full_disk_is_one_line_and_the_sweep_goes_on_later(
    tmp_path, toy_environment, monkeypatch, samples, name
):
    monkeypatch.setenv("TOY_CURVE_SAMPLES", samples)
    run(tmp_path / "whole")
    whole, folder = left_by(tmp_path / "whole"), tmp_path / "full"
    process = toy_sweep.start(
        folder, 1, toy_environment, prepare=fills_up_at(4000), TOY_CURVE_SAMPLES=samples
    )
    code, line = end(process)
    assert code == 1
    assert f"cannot write {folder / name}: File too large; " in line
    assert f"of 16 trials are kept in {folder}, and the same command resumes" in line
    written = (folder / name).read_bytes()
    assert len(written) == 4000 and whole[name].startswith(written)
    assert len(records.read_rows(folder / "trials.csv", TrialResult)) > 2
    run(folder)
    assert left_by(folder) == whole


def test_a_disk_that_fills_up_with_rows_before_their_turn(tmp_path, toy_environment, unbroken):
    folder = tmp_path / "full"
    settings = {"TOY_SLOW_ONCE": str(tmp_path / "slow_once"), "TOY_SLOW_S": "30"}
    code, line = end(
        toy_sweep.start(folder, 2, toy_environment, prepare=fills_up_at(4000), **settings)
    )
    assert code == 1
    assert f"cannot write {folder / 'pending.jsonl'}: File too large; " in line
    kept = read_lines(folder)
    assert f"; {len(kept)} of 16 trials are kept" in line
    assert len(kept) > 3
    run(folder)
    assert left_by(folder) == unbroken
    timings = (folder / "timings.csv").read_text()
    assert all(lines.timings in timings for lines in kept.values())


def test_a_disk_that_is_full_from_the_start(tmp_path, toy_environment):
    process = toy_sweep.start(tmp_path / "full", 1, toy_environment, prepare=fills_up_at(100))
    code, line = end(process)
    assert code == 1
    assert line == f"cannot write {tmp_path / 'full' / 'manifest.json'}: File too large"


def test_a_folder_that_turns_read_only(copy, read_only, toy_environment, unbroken):
    lines = unbroken["trials.csv"].splitlines(keepends=True)
    (copy / "trials.csv").write_bytes(b"".join(lines[:9]))
    read_only(copy)
    wrapper = obeying_permissions()
    code, line = end(toy_sweep.start(copy, 1, toy_environment, wrapper=wrapper))
    assert (code, line) == (1, f"cannot write to {copy}: Permission denied")
    assert (copy / "trials.csv").read_bytes() == b"".join(lines[:9])


def test_a_file_that_may_not_be_written(copy, toy_environment, read_only, unbroken):
    lines = unbroken["trials.csv"].splitlines(keepends=True)
    (copy / "trials.csv").write_bytes(b"".join(lines[:9]))
    read_only(copy)
    copy.chmod(0o755)
    (copy / ".lock").chmod(0o644)
    wrapper = obeying_permissions()
    code, line = end(toy_sweep.start(copy, 1, toy_environment, wrapper=wrapper))
    assert code == 1
    assert f"{copy / 'timings.csv'}" in line and "Permission denied" in line
    assert (copy / "trials.csv").read_bytes() == b"".join(lines[:9])


def test_a_folder_that_cannot_be_made(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OSError, match=r"cannot write to .*/file/out: Not a directory"):
        run(tmp_path / "file" / "out")


def test_a_crash_whose_message_is_no_text_is_a_row(tmp_path, monkeypatch):
    monkeypatch.setenv("TOY_CRASH_SEEDS", "2")
    monkeypatch.setenv("TOY_CRASH_MESSAGE", "no file \udcff")
    done = run(tmp_path / "out")
    assert done.error_count == 4
    rows = records.read_rows(done.trials_path, TrialResult)
    (detail,) = {row.detail for row in rows if row.outcome == "error"}
    assert detail == "ZeroDivisionError: no file \\udcff"
    tracebacks = [path.read_text() for path in (tmp_path / "out" / "errors").iterdir()]
    assert all(text.endswith("ZeroDivisionError: no file \\udcff\n") for text in tracebacks)


def test_the_lock_ends_with_its_block(tmp_path):
    with exclusive(tmp_path), pytest.raises(ValueError, match="another sweep"), exclusive(tmp_path):
        pass
    with exclusive(tmp_path):
        pass
