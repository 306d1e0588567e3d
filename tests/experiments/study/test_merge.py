import json
import shutil
from dataclasses import asdict, replace

import pytest
import toy_sweep
from experiments.belt.sweep import run_sweep
from experiments.study.members import append_member, keep_members
from experiments.study.results_folder import read_lines
from experiments.study.shards import Shard
from toy_sweep import PRESET, left_by

from experiments.belt.config import TrialResult, TrialTimings
from experiments.belt.curves import CURVE_HEADER
from experiments.study import manifest, records
from experiments.study.merge import merge
from experiments.study.processes import LocalWorkers

SHARD_COUNT = 3


def run(preset, folder):
    return run_sweep(preset, folder, LocalWorkers(1), "failures", toy_sweep.TOY)


@pytest.fixture(scope="module")
def finished_shards(tmp_path_factory):
    """Folders of the shards of the toy sweep; trials of seed 3 have crashed."""
    folders = [tmp_path_factory.mktemp("shards") / str(n) for n in range(1, SHARD_COUNT + 1)]
    for number, folder in enumerate(folders, start=1):
        run(replace(PRESET, shard=Shard(number, SHARD_COUNT)), folder)
    return folders


@pytest.fixture
def shards(finished_shards, tmp_path):
    """Copies of them, to do harm to."""
    return [shutil.copytree(folder, tmp_path / folder.name) for folder in finished_shards]


def leave(folder, count):
    """Takes all rows but the first away, as if the shard had not got any further."""
    for name, row_type in (("trials.csv", TrialResult), ("timings.csv", TrialTimings)):
        records.keep_lines(folder / name, records.header_line(row_type), count)
    keep_members(folder / "curves.csv.gz", CURVE_HEADER, count)


def test_shards_together_are_the_bytes_of_the_whole_sweep(shards, unbroken, tmp_path):
    merged = merge(list(reversed(shards)), tmp_path / "all")
    assert left_by(tmp_path / "all") == unbroken
    assert (merged.trial_count, merged.missing) == (16, ())
    timings = records.read_rows(tmp_path / "all" / "timings.csv", TrialTimings)
    assert [row.trial_id for row in timings] == [trial.trial_id for trial in PRESET.trials]
    content = manifest.read_manifest(tmp_path / "all")
    assert content["shards"] == {"1/3": 6, "2/3": 5, "3/3": 5}
    assert [session["shard"] for session in content["sessions"]] == ["3/3", "2/3", "1/3"]
    assert "finished_utc" in content
    assert not (tmp_path / "all" / "pending.jsonl").exists()
    videos = [path.name for folder in shards for path in (folder / "videos").iterdir()]
    assert sorted(videos) == sorted(path.name for path in (tmp_path / "all" / "videos").iterdir())


def test_a_merged_sweep_is_one_that_nothing_is_missing_of(shards, unbroken, tmp_path, monkeypatch):
    merge(shards, tmp_path / "all")
    monkeypatch.setenv("TOY_CRASH_SEEDS", "0,1,2,3")
    assert run_sweep(PRESET, tmp_path / "all", LocalWorkers(1), run_trial=toy_sweep.TOY)
    assert left_by(tmp_path / "all") == unbroken


def test_what_is_missing_is_told_and_can_be_run(shards, unbroken, tmp_path):
    leave(shards[2], 4)
    merged = merge([shards[0], shards[2]], tmp_path / "all")
    assert merged.trial_count == 10
    second, third = merged.missing
    assert second.startswith("shard 2/3 lacks 5 of 5 trials: ")
    assert second.endswith("; and 2 more")
    assert third.startswith("shard 3/3 lacks 1 of 5 trials: igpf at 0.1 m/s, normal, seed 3")
    assert "finished_utc" not in manifest.read_manifest(tmp_path / "all")
    run_sweep(PRESET, tmp_path / "all", LocalWorkers(2), run_trial=toy_sweep.TOY)
    assert left_by(tmp_path / "all") == unbroken


def test_what_comes_later_is_merged_into_what_is_there(shards, unbroken, tmp_path):
    late = shutil.copytree(shards[0], tmp_path / "late")
    leave(shards[0], 2)
    merge(shards[:2], tmp_path / "all")
    merged = merge([late, shards[2]], tmp_path / "all")
    assert not merged.missing
    assert left_by(tmp_path / "all") == unbroken
    assert len(manifest.read_manifest(tmp_path / "all")["sessions"]) == SHARD_COUNT
    assert manifest.read_manifest(tmp_path / "all")["shards"] == {"1/3": 6, "2/3": 5, "3/3": 5}


def test_rows_that_wait_for_their_turn_are_merged_too(shards, tmp_path):
    *_, (trial_id, lines) = read_lines(shards[0]).items()
    leave(shards[0], 3)
    entry = {"index": 5, **asdict(lines)}
    (shards[0] / "pending.jsonl").write_text(json.dumps(entry) + "\n")
    merged = merge(shards, tmp_path / "all")
    assert merged.missing[0].startswith("shard 1/3 lacks 2 of 6 trials")
    assert read_lines(tmp_path / "all")[trial_id] == lines


def test_errors_come_along(tmp_path, monkeypatch):
    monkeypatch.setenv("TOY_CRASH_SEEDS", "2")
    shards = [tmp_path / "1", tmp_path / "2"]
    for number, folder in enumerate(shards, start=1):
        assert run(replace(PRESET, shard=Shard(number, 2)), folder).error_count > 0 or number == 2
    merge(shards, tmp_path / "all")
    tracebacks = {path.stem for path in (tmp_path / "all" / "errors").iterdir()}
    assert tracebacks == {trial.trial_id for trial in PRESET.trials if trial.seed == 2}


def test_a_row_that_two_shards_tell_differently_is_refused(shards, tmp_path):
    other = shutil.copytree(shards[0], tmp_path / "other")
    text = (other / "trials.csv").read_text()
    (other / "trials.csv").write_text(text.replace(",abc,", ",abd,", 1))
    with pytest.raises(ValueError, match=r"trial \w+ \(.* seed 0\) has one row or curve in .* and"):
        merge([*shards, other], tmp_path / "all")
    assert not (tmp_path / "all" / "trials.csv").exists()


def test_a_curve_that_two_shards_tell_differently_is_refused(shards, tmp_path):
    other = shutil.copytree(shards[0], tmp_path / "other")
    leave(other, 0)
    trial_id, lines = next(iter(read_lines(shards[0]).items()))
    records.append_line(other / "trials.csv", lines.trial)
    records.append_line(other / "timings.csv", lines.timings)
    append_member(other / "curves.csv.gz", f"{trial_id},0.0000,,1.00000\n")
    with pytest.raises(ValueError, match=rf"trial {trial_id} .* has one row or curve in"):
        merge([*shards, other], tmp_path / "all")


@pytest.mark.parametrize("name", ["timings.csv", "curves.csv.gz"])
def test_a_shard_that_lacks_a_file_is_refused(shards, tmp_path, name):
    (shards[1] / name).unlink()
    with pytest.raises(ValueError, match=rf"2/{name} is not that of trials\.csv"):
        merge(shards, tmp_path / "all")


@pytest.mark.parametrize(
    ("other", "message"),
    [
        (replace(PRESET, name="toys"), "holds results of preset 'toys', .* of 'toy'"),
        (replace(PRESET, seeds=(0, 1)), "hold preset 'toy' with other cells or seeds"),
    ],
)
def test_shards_of_another_sweep_are_refused(shards, tmp_path, other, message):
    run(replace(other, shard=Shard(1, 2)), tmp_path / "other")
    with pytest.raises(ValueError, match=message):
        merge([*shards, tmp_path / "other"], tmp_path / "all")


def test_what_holds_no_shard_is_refused(shards, tmp_path):
    (tmp_path / "empty").mkdir()
    with pytest.raises(ValueError, match=r"empty has no manifest\.json of a sweep"):
        merge([tmp_path / "empty"], tmp_path / "all")
    with pytest.raises(ValueError, match="1 holds shard 1/3; choose another folder"):
        merge(shards[1:], shards[0])
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "trials.csv").write_text("mine\n")
    with pytest.raises(ValueError, match="mine holds results without manifest"):
        merge(shards, tmp_path / "mine")
    with pytest.raises(ValueError, match="folders of one shard at least"):
        merge([], tmp_path / "all")


def test_a_shard_does_not_share_its_folder(shards):
    message = "holds shard 1/3 of preset 'toy', not shard 2/3"
    with pytest.raises(ValueError, match=message):
        run(replace(PRESET, shard=Shard(2, SHARD_COUNT)), shards[0])
    with pytest.raises(ValueError, match="holds shard 1/3 of preset 'toy', not the whole"):
        run(PRESET, shards[0])
