"""The rendered experiments from world to table, as their users run them."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from experiments import cli
from experiments.apple.approach import ApproachJob, approach_rows, errors_deg
from experiments.apple.methods import METHODS, Estimate
from experiments.apple.photographs import MASKS, ORACLE, SEGMENTED, ArmPhotographer, sighting
from experiments.apple.published import published_table
from experiments.apple.rendered_tables import approach_tables
from experiments.apple.replay import ReplayJob, aimed, draw_replay, published_errors_deg
from experiments.apple.study import get_study
from experiments.apple.viewpoints import VIEWS, Viewing, along_the_arc
from experiments.apple.worlds import WorldId, draw_world
from experiments.study.folder import read_results
from tracker.apple.attitude import axis_error_deg
from tracker.apple.view import FruitStatus, FruitView

WORLD = WorldId("visible", 0.85, 1001)


@pytest.fixture(scope="module")
def rows():
    return approach_rows(ApproachJob(WORLD))


def test_a_world_has_a_row_for_each_mask_and_method(rows):
    assert [(row.mask, row.method) for row in rows] == [(m, n) for m in MASKS for n in METHODS]
    for row in rows:
        assert row.image_count == row.found_count == row.calyx_count == row.arm_count == 8
        assert row.visible_share > 0.98
        assert row.is_sign_right


def test_the_fit_beats_the_mean_image(rows):
    errors = {row.method: row.error_deg for row in rows if row.mask == SEGMENTED}
    assert errors["silhouettes"] < 1.5
    assert errors["silhouettes"] < min(errors["single-paper"], errors["single-perspective"])
    single = next(row for row in rows if row.method == "single-paper")
    images = [getattr(single, f"error_{k}_deg") for k in range(1, 9)]
    assert single.error_deg == pytest.approx(np.mean(images))


def test_the_same_world_gives_the_same_rows_again(rows):
    assert approach_rows(ApproachJob(WORLD)) == rows


def test_where_the_arm_stops_short_the_last_error_stands(monkeypatch, rows):
    def short(planned, take, seed):
        return along_the_arc(planned[:3], take, seed)

    monkeypatch.setitem(VIEWS, "arc", Viewing("three images", short))
    for row, whole in zip(approach_rows(ApproachJob(WORLD)), rows, strict=True):
        assert row.image_count == row.arm_count == 3
        errors = [getattr(row, f"error_{k}_deg") for k in range(1, 9)]
        assert errors[:3] == [getattr(whole, f"error_{k}_deg") for k in range(1, 4)]
        assert errors[3:] == [errors[2]] * 5
        if METHODS[row.method].is_fused:
            assert row.error_deg == errors[2]


def test_segmentation_sees_what_the_oracle_sees():
    world = draw_world(WORLD)
    with world.build() as orchard:
        photograph = ArmPhotographer(orchard, 1)(world.approach[0])
    by_colour, by_oracle = (sighting(photograph, mask).view for mask in (SEGMENTED, ORACLE))
    assert by_colour.centre_px == pytest.approx(by_oracle.centre_px, abs=0.3)
    assert by_colour.semi_axes_px == pytest.approx(by_oracle.semi_axes_px, abs=0.3)
    assert by_colour.calyx_px == pytest.approx(by_oracle.calyx_px, abs=0.5)


def test_the_next_best_views_leave_the_arc_at_the_planned_distances():
    world = draw_world(WorldId("hidden", 0.92, 1002))
    with world.build() as orchard:
        taken = VIEWS["next-best"].take(world.approach, ArmPhotographer(orchard, 2), 2)
    places = np.array([p.true_pose[:3, 3] for p in taken])
    planned = np.array([T[:3, 3] for T in world.approach])
    assert places[:2] == pytest.approx(planned[:2], abs=2e-3)
    assert np.linalg.norm(places[2:] - planned[2:], axis=1).max() > 0.1
    ranges = [np.linalg.norm(p - world.fruit.centre_m, axis=1) for p in (places, planned)]
    assert ranges[0] == pytest.approx(ranges[1], abs=0.05)


def test_no_estimate_counts_as_the_worst_error():
    axis = np.array([0.0, 0.0, 1.0])
    assert errors_deg([None, Estimate(-axis)], axis) == [90.0, 0.0]


@pytest.mark.parametrize("method", METHODS)
def test_a_method_survives_images_without_a_fruit(method):
    world = draw_world(WORLD)
    with world.build() as orchard:
        photographer = ArmPhotographer(orchard, 1)
        seen = [sighting(photographer(T), SEGMENTED) for T in world.approach[:2]]
    blind = replace(seen[0], view=FruitView(FruitStatus.NO_FRUIT))
    estimates = METHODS[method].run([blind, seen[0], blind, seen[1]], 0)
    assert len(estimates) == 4 and estimates[0] is None
    assert (estimates[2] is not None) == METHODS[method].is_fused
    assert METHODS[method].run([blind, blind], 0) == [None, None]


def test_the_published_poses_look_at_the_fruit_from_where_they_were():
    config, poses = draw_replay(ReplayJob(1, 0.9, 0))
    table = published_table(1)
    for T, place, pose in zip(poses, table.position_m, table.camera_poses, strict=True):
        assert T[:3, 3] == pytest.approx(place)
        toward = config.fruit.centre_m - place
        assert T[:3, 2] == pytest.approx(toward / np.linalg.norm(toward))
        turned = np.degrees(np.arccos(np.clip(T[:3, 2] @ pose.rotation[:, 2], -1.0, 1.0)))
        assert turned < 25.0
    assert config.fruit.axis == pytest.approx([0.0, 0.0, 1.0])


def test_aiming_turns_by_no_more_than_needed():
    T = aimed(np.eye(3), np.zeros(3), np.array([0.0, 0.3, 1.0]))
    angle = np.degrees(np.arccos(0.5 * (np.trace(T[:3, :3]) - 1.0)))
    assert angle == pytest.approx(np.degrees(np.arctan(0.3)))
    assert T[:3, :3].T @ T[:3, :3] == pytest.approx(np.eye(3))


def test_published_errors_are_those_of_the_tables():
    table = published_table(2)
    last = np.cos(np.radians(table.estimate_deg[-1]))
    _, end = published_errors_deg(2)
    assert end == pytest.approx(float(axis_error_deg(last / np.linalg.norm(last), table.true_axis)))


def test_tables_tell_medians_and_pairs(rows):
    best = [replace(row, views="next-best", error_deg=0.5 * row.error_deg) for row in rows]
    tables = approach_tables([*rows, *best])
    line = next(r for r in tables["methods"].rows if r["method"] == "silhouettes")
    error = next(r.error_deg for r in rows if (r.method, r.mask) == ("silhouettes", SEGMENTED))
    assert line["median_deg"] == line["mean_deg"] == pytest.approx(error)
    pair = tables["views"].rows[0]
    assert pair["gain_deg"] == pytest.approx(-0.5 * error)
    assert set(tables) == {"methods", "views", "masks", "segmentation", "images"}


def beltgrasp(*words):
    command = [sys.executable, "-m", "experiments.cli", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_an_approach_by_the_command_line(rows, tmp_path):
    out = tmp_path / "approach"
    words = ["apple", "approach", "--out", out, "--classes", "visible", "--aspects", "0.85"]
    run = beltgrasp(*words, "--first-seed", 1001, "--seeds", 1, "--workers", 1)
    assert run.returncode == 0, run.stderr
    assert f"1 world: {out / 'rows.csv'}" in run.stdout
    read = read_results(out, get_study("apple/approach")).rows
    assert [(r.mask, r.method) for r in read] == [(r.mask, r.method) for r in rows]
    assert [r.error_deg for r in read] == pytest.approx([r.error_deg for r in rows], rel=1e-6)
    report = beltgrasp("report", out)
    assert report.returncode == 0, report.stderr
    assert "silhouettes" in report.stdout
    for name in ("methods", "masks", "segmentation", "images"):
        assert {p.suffix for p in out.glob(f"tables/{name}.*")} == {".csv", ".md", ".tex"}
    assert {p.name for p in out.glob("figures/*.png")} == {"error_by_image.png", "error_spread.png"}


@pytest.mark.slow
def test_a_replay_by_the_command_line(tmp_path):
    out = tmp_path / "replay"
    words = ["--tables", 2, "--aspects", 0.9, "--seeds", 1, "--workers", 1]
    run = beltgrasp("apple", "replay", "--out", out, *words)
    assert run.returncode == 0, run.stderr
    report = beltgrasp("report", out)
    assert "published, filter (end)" in report.stdout
    assert (out / "figures" / "table2.png").exists()


@pytest.mark.slow
def test_a_film_by_the_command_line(tmp_path):
    words = ["--classes", "visible", "--aspects", 0.9, "--seeds", 1, "--workers", 1]
    run = beltgrasp("apple", "approach", *words, "--video", "all", "--out", tmp_path)
    assert run.returncode == 0, run.stderr
    (film,) = (tmp_path / "videos").iterdir()
    assert film.stat().st_size > 50_000
    assert film.name == "PASS_done_visible_aspect_0.9_arc_seed_0_visible_0.9_0_arc.mp4"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["approach", "--out", "NEW", "--classes", "visibel"], "did you mean 'visible'?"),
        (["approach", "--out", "NEW", "--views", "best"], "views must be one of arc, next-best"),
        (["approach", "--out", "NEW", "--aspects", "1.5"], "aspect must be from 0.5"),
        (["approach", "--out", "NEW", "--seeds", "0"], "seeds must be 1 or greater, got 0"),
        (["approach", "--out", "NEW", "--first-seed", "-1"], "first-seed must be 0 or greater"),
        (["approach", "--out", "NEW", "--workers", "0"], "workers must be 1 or greater, got 0"),
        (["replay", "--out", "NEW", "--tables", "3"], "table must be one of (1, 2), got 3"),
        (["replay", "--out", "NEW", "--video", "all"], "apple/replay has no videos"),
    ],
)
def test_what_is_wrong_is_told_in_one_line(tmp_path, capsys, words, message):
    words = [str(tmp_path / "new") if word == "NEW" else word for word in words]
    assert cli.run(["apple", *words]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1
