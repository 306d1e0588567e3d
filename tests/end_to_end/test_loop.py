"""The command line as a user meets it, with the real world behind it."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

BELTGRASP = [sys.executable, "-m", "experiments.cli"]
ROOT = Path(__file__).resolve().parents[2]


def beltgrasp(
    *arguments: str | Path, check: bool = True, cwd: Path = ROOT
) -> subprocess.CompletedProcess[str]:
    command = [*BELTGRASP, *map(str, arguments)]
    run = subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False)
    assert not check or run.returncode == 0, run.stderr
    assert "Traceback" not in run.stderr, run.stderr
    return run


@pytest.fixture(scope="module")
def smoke(tmp_path_factory) -> Path:
    """A finished sweep of the smallest preset, with one worker."""
    folder = tmp_path_factory.mktemp("sweep") / "smoke"
    beltgrasp("sweep", "smoke", "--out", folder, "--workers", "1")
    return folder


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "rows.csv").open() as file:
        return list(csv.DictReader(file))


def test_sweep_grasps_by_sight_and_writes_a_row_a_trial(smoke):
    by_tracker = {row["tracker"]: row for row in rows(smoke)}
    assert by_tracker["igpf"]["outcome"] == "success"
    assert by_tracker["oracle"]["outcome"] == "success"
    assert by_tracker["static"]["outcome"] != "success"
    assert by_tracker["igpf"]["gl_renderer"] != "none" == by_tracker["oracle"]["gl_renderer"]


def test_killed_sweep_of_two_workers_resumes_to_the_bytes_of_one_unbroken(smoke, tmp_path):
    folder = tmp_path / "killed"
    command = [*BELTGRASP, "sweep", "smoke", "--out", str(folder), "--workers", "2"]
    process = subprocess.Popen(
        command,
        cwd=ROOT,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    journal = folder / "journal.jsonl"
    while process.poll() is None and not (journal.exists() and journal.read_bytes().count(b"\n")):
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    if process.returncode == 0:  # it was faster than the kill: leave less, as a kill does
        lines = (folder / "rows.csv").read_bytes().splitlines(keepends=True)
        (folder / "rows.csv").write_bytes(b"".join(lines[:3]))
    beltgrasp("sweep", "smoke", "--out", folder, "--workers", "2")
    for name in ("rows.csv", "curves.csv.gz"):
        assert (folder / name).read_bytes() == (smoke / name).read_bytes()


def test_trial_in_another_process_gives_the_row_of_the_sweep(smoke):
    out = beltgrasp("trial", "--tracker", "igpf", "--speed-mps", "0.5", "--seed", "0", "--json")
    alone = json.loads(out.stdout)
    swept = next(row for row in rows(smoke) if row["tracker"] == "igpf")
    assert alone["trial_id"] == swept["trial_id"]
    for name in ("track_rmse_m", "close_error_m", "simulated_s", "max_tilt_rad"):
        assert float(swept[name]) == pytest.approx(alone[name], rel=1e-8)


def test_report_leaves_tables_and_figures(smoke):
    out = beltgrasp("report", smoke)
    assert "igpf" in out.stdout
    for name in ("tables/success.csv", "tables/success.md", "figures/outcomes.png"):
        assert (smoke / name).stat().st_size > 0


def test_video_shows_the_trial(tmp_path):
    import cv2

    path = tmp_path / "trial.mp4"
    beltgrasp("trial", "--tracker", "igpf", "--speed-mps", "1.0", "--seed", "3", "--video", path)
    capture = cv2.VideoCapture(str(path))
    count, width = capture.get(cv2.CAP_PROP_FRAME_COUNT), capture.get(cv2.CAP_PROP_FRAME_WIDTH)
    assert count > 30 and width == 1280


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["trial", "--tracker", "igfp"], "igpf"),
        (["trial", "--speed-mps", "-1"], "speed_mps must be a number from 0 to 3, got -1"),
        (["trial", "--camera-rate-hz", "50"], "camera_rate_hz must divide 480"),
        (["sweep", "smok", "--out", "nowhere"], "smoke"),
        (["report", "no-such-folder"], "no-such-folder"),
    ],
)
def test_mistakes_get_one_line(arguments, message):
    run = beltgrasp(*arguments, check=False)
    assert run.returncode == 2
    assert message in run.stderr


def test_the_tracker_of_the_guide_grasps_in_the_loop():
    folder = ROOT / "docs" / "examples"
    run = beltgrasp("trial", "--tracker", "corner_flow:CornerFlow", "--json", cwd=folder)
    assert json.loads(run.stdout)["outcome"] == "success"
