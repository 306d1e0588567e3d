"""The tables of the replays, worked out by hand on a few rows."""

import csv

import pytest

from experiments.apple.photographs import ORACLE, SEGMENTED
from experiments.apple.rendered_tables import final_errors_deg, pose_table, replay_method_table
from experiments.apple.replay import ReplayRow, published_errors_deg


def images(method, aspect, errors_deg, mask=SEGMENTED, seed=0):
    """The rows of one fruit of Table 2, image by image."""
    return [
        ReplayRow(2, aspect, seed, mask, method, image, image == 1, 0.5 * image, "found",
                  image == 2, None, None, None, error_deg)
        for image, error_deg in enumerate(errors_deg, start=1)
    ]  # fmt: skip


@pytest.fixture
def rows():
    return [
        *images("single-paper", 0.9, [4.0, 8.0]),
        *images("single-paper", 0.9, [2.0, 2.0], ORACLE),
        *images("silhouettes", 0.8, [9.0, 1.0]),
        *images("silhouettes", 0.9, [9.0, 3.0]),
        *images("silhouettes", 0.9, [9.0, 0.5], ORACLE),
    ]


def test_a_fused_method_has_its_last_error_and_single_images_their_mean(rows):
    assert final_errors_deg(rows) == [6.0, 2.0, 1.0, 3.0, 0.5]


def test_methods_stand_beside_what_was_published(rows):
    published = published_errors_deg(2)
    single, end, images_, fit = replay_method_table(rows).rows
    assert (single["median_deg"], end["median_deg"]) == published
    assert (single["n"], single["p90_deg"], single["aspect_0.9_deg"]) == (None, None, None)
    assert (images_["n"], images_["median_deg"], images_["oracle_deg"]) == (1, 6.0, 2.0)
    assert (images_["aspect_0.8_deg"], images_["aspect_0.9_deg"]) == (None, 6.0)
    assert (fit["n"], fit["median_deg"], fit["p90_deg"]) == (2, 2.0, pytest.approx(2.8))
    assert (fit["aspect_0.8_deg"], fit["aspect_0.9_deg"], fit["oracle_deg"]) == (1.0, 3.0, 0.5)
    assert (fit["median_low_deg"], fit["median_high_deg"]) == (1.0, 3.0)


def test_the_csv_has_a_head_for_every_column(rows):
    first, *_, last = csv.DictReader(replay_method_table(rows).to_csv().splitlines())
    assert None not in last and first["aspect_0.9_deg"] == "" and last["aspect_0.9_deg"] == "3"


def test_poses_are_counted_once_for_all_methods(rows):
    first, second = pose_table(rows).rows
    assert (first["n"], first["range_m"], first["by_arm"], first["calyx"]) == (1, 0.5, True, 0.0)
    assert (second["n"], second["by_arm"], second["found"], second["calyx"]) == (1, False, 1.0, 1.0)
