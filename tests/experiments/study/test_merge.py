"""Shards of the toy put together: whole, in part, later, and such that do not belong together."""

import shutil

import pytest
import toy_study
from toy_study import JOB_COUNT, SELECTION, STUDY, left_by, run_toy

from experiments.study.folder import read_entries, read_results, write_entries
from experiments.study.manifest import Manifest
from experiments.study.merge import merge
from experiments.study.shard import Shard

SHARD_COUNT = 3


def run_shard(folder, number, count=SHARD_COUNT, **options):
    return run_toy(folder, shard=Shard(number, count), **options)


@pytest.fixture(scope="module")
def finished_shards(tmp_path_factory):
    """Folders of the shards of the toy."""
    folders = [tmp_path_factory.mktemp("shards") / str(n) for n in range(1, SHARD_COUNT + 1)]
    for number, folder in enumerate(folders, start=1):
        run_shard(folder, number, video="failures")
    return folders


@pytest.fixture
def shards(finished_shards, tmp_path):
    """Copies of them, to do harm to."""
    return [shutil.copytree(folder, tmp_path / folder.name) for folder in finished_shards]


def leave(folder, count):
    """Takes all jobs but the first away, as if the shard had not got any further."""
    write_entries(folder, STUDY, list(read_entries(folder, STUDY).values())[:count])


def test_shards_together_are_the_bytes_of_the_whole(shards, unbroken, tmp_path):
    merged = merge(STUDY, [*reversed(shards)], tmp_path / "all")
    assert left_by(tmp_path / "all") == unbroken
    assert (merged.job_count, merged.missing) == (JOB_COUNT, ())
    assert merged.rows_path == tmp_path / "all" / "rows.csv"
    times = {line for folder in shards for line in (folder / "timings.csv").read_text().split()}
    assert set((tmp_path / "all" / "timings.csv").read_text().split()) == times
    whole = Manifest.read(tmp_path / "all")
    assert (whole.study, whole.shard, whole.selections) == ("toy/sums", None, [SELECTION])
    assert whole.settings == Manifest.read(shards[0]).settings
    assert [session["shard"] for session in whole.sessions] == ["3/3", "2/3", "1/3"]
    videos = [path.name for folder in shards for path in (folder / "videos").iterdir()]
    assert sorted(videos) == sorted(path.name for path in (tmp_path / "all" / "videos").iterdir())
    assert len(videos) == JOB_COUNT // 2


def test_nothing_is_missing_of_what_was_merged(shards, unbroken, tmp_path, monkeypatch):
    merge(STUDY, shards, tmp_path / "all")
    monkeypatch.setenv("TOY_CRASH_SEEDS", "0,1,2,3,4,5")
    assert run_toy(tmp_path / "all").error_count == 0
    assert left_by(tmp_path / "all") == unbroken


def test_what_is_missing_is_told_and_can_be_run(shards, unbroken, tmp_path):
    leave(shards[2], 3)
    merged = merge(STUDY, [shards[0], shards[2]], tmp_path / "all")
    assert merged.job_count == 7
    second, third = merged.missing
    assert second.startswith("shard 2/3 lacks 4 of 4 sums: ")
    assert second.endswith("; and 1 more")
    assert third == "shard 3/3 lacks 1 of 4 sums: igpf, seed 5"
    run_toy(tmp_path / "all")
    assert left_by(tmp_path / "all") == unbroken


def test_of_folders_that_are_no_shards_the_whole_is_told(tmp_path):
    for name in ("pf", "igpf"):
        run_toy(tmp_path / name, SELECTION | {"methods": [name]})
    leave(tmp_path / "pf", 5)
    merged = merge(STUDY, [tmp_path / "pf", tmp_path / "igpf"], tmp_path / "all")
    assert merged.missing == ("missing: 1 of 12 sums: pf, seed 5",)


def test_what_comes_later_is_merged_into_what_is_there(shards, unbroken, tmp_path):
    late = shutil.copytree(shards[0], tmp_path / "late")
    leave(shards[0], 2)
    merge(STUDY, shards[:2], tmp_path / "all")
    merged = merge(STUDY, [late, shards[2]], tmp_path / "all")
    assert not merged.missing
    assert left_by(tmp_path / "all") == unbroken
    assert len(Manifest.read(tmp_path / "all").sessions) == SHARD_COUNT


def test_a_shard_that_still_runs_is_merged_as_far_as_it_is(shards, unbroken, tmp_path):
    """Its journal and a file that it is writing are there."""
    whole = read_entries(shards[0], STUDY)
    running = tmp_path / "running"
    process = toy_study.start(running, 1, TOY_SLEEP_S="0.1")
    toy_study.wait_for_jobs(running, process, 2)
    toy_study.kill_group(process)
    content = Manifest.read(running)
    content.shard = Shard(1, 1)
    content.write(running)
    (running / "notes" / ".x.new").write_text("torn")
    assert (running / "journal.jsonl").exists()
    merged = merge(STUDY, [shards[1], running], tmp_path / "all")
    assert len(whole) < merged.job_count < JOB_COUNT
    assert not (tmp_path / "all" / "notes" / ".x.new").exists()
    assert (running / "journal.jsonl").exists()
    run_toy(tmp_path / "all")
    assert left_by(tmp_path / "all") == unbroken


def test_errors_come_along_and_a_good_row_stands_before_a_crash(tmp_path, unbroken, monkeypatch):
    shards = [tmp_path / "1", tmp_path / "2"]
    monkeypatch.setenv("TOY_CRASH_SEEDS", "2")
    assert [run_shard(path, n, 2).error_count for n, path in enumerate(shards, 1)] == [2, 0]
    merge(STUDY, shards, tmp_path / "all")
    tracebacks = {path.stem for path in (tmp_path / "all" / "errors").iterdir()}
    assert tracebacks == {"pf_2", "igpf_2"}
    monkeypatch.delenv("TOY_CRASH_SEEDS")
    mended = shutil.copytree(shards[0], tmp_path / "mended")
    assert run_shard(mended, 1, 2).error_count == 0
    for name, order in (("x", [mended, *shards]), ("y", [*shards, mended])):
        merge(STUDY, order, tmp_path / name)
        assert left_by(tmp_path / name) == unbroken
    merge(STUDY, [mended], tmp_path / "all")
    assert left_by(tmp_path / "all") == unbroken


def test_shards_of_a_study_that_grew_are_merged(tmp_path, unbroken):
    for number in (1, 2):
        for seeds in ([4, 5], [0, 1, 2, 3, 4, 5]):
            run_toy(tmp_path / str(number), SELECTION | {"seeds": seeds}, shard=Shard(number, 2))
    merged = merge(STUDY, [tmp_path / "1", tmp_path / "2"], tmp_path / "all")
    assert not merged.missing
    assert left_by(tmp_path / "all") == unbroken


@pytest.mark.parametrize("name", ["rows.csv", "curves.csv.gz"])
def test_a_job_that_two_shards_tell_differently_is_refused(shards, tmp_path, name):
    other = shutil.copytree(shards[0], tmp_path / "other")
    entries = read_entries(other, STUDY)
    key, entry = next(iter(entries.items()))
    if name == "rows.csv":
        object.__setattr__(entry, "rows", entry.rows.replace("done,", "done,9", 1))
    else:
        object.__setattr__(entry, "curves", {"curves": f"{','.join(key)},0,9\n"})
    write_entries(other, STUDY, [*entries.values()])
    message = rf"sum pf 0 has one row or curve in {shards[0]} and another in {tmp_path / 'other'}"
    with pytest.raises(ValueError, match=message):
        merge(STUDY, [*shards, other], tmp_path / "all")
    assert not (tmp_path / "all" / "rows.csv").exists()
    assert not (tmp_path / "all" / "manifest.json").exists()


@pytest.mark.parametrize("name", ["timings.csv", "curves.csv.gz"])
def test_a_shard_that_lacks_a_file_is_refused(shards, tmp_path, name):
    (shards[1] / name).unlink()
    with pytest.raises(ValueError, match=rf"2/{name} is missing beside rows\.csv"):
        merge(STUDY, shards, tmp_path / "all")


def test_shards_of_other_studies_and_settings_are_refused(shards, tmp_path):
    other = Manifest.read(shards[1])
    for study, settings, message in (
        ("toy/others", other.settings, "2 holds results of toy/others, not of toy/sums; choose"),
        ("toy/sums", {"method pf": {"gain": "2.0"}},
         r"2 holds results with other settings: method pf\.gain was 1\.0, is 2\.0; choose"),
    ):  # fmt: skip
        other.study, other.settings = study, settings
        other.write(shards[1])
        with pytest.raises(ValueError, match=message):
            merge(STUDY, shards, tmp_path / "all")
        assert not (tmp_path / "all" / "rows.csv").exists()


def test_what_holds_no_shard_is_refused(shards, tmp_path):
    (tmp_path / "empty").mkdir()
    with pytest.raises(ValueError, match=r"empty holds no results: it has no manifest\.json"):
        merge(STUDY, [tmp_path / "empty"], tmp_path / "all")
    with pytest.raises(ValueError, match="1 holds shard 1/3; choose another folder"):
        merge(STUDY, shards[1:], shards[0])
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "trials.csv").write_text("mine\n")
    with pytest.raises(ValueError, match="mine holds results without their manifest"):
        merge(STUDY, shards, tmp_path / "mine")
    assert (tmp_path / "mine" / "trials.csv").read_text() == "mine\n"


def test_a_row_of_another_selection_is_refused(shards, tmp_path):
    lost = Manifest.read(shards[0])
    lost.selections = [SELECTION | {"seeds": [0]}]
    lost.write(shards[0])
    with pytest.raises(ValueError, match="1 holds a row of another selection: igpf"):
        merge(STUDY, shards, tmp_path / "all")


def test_a_shard_does_not_share_its_folder(shards):
    with pytest.raises(ValueError, match="holds shard 1/3 of toy/sums, not shard 2/3; choose"):
        run_shard(shards[0], 2)
    with pytest.raises(ValueError, match="holds shard 1/3 of toy/sums, not the whole; choose"):
        run_toy(shards[0])
    assert len(read_results(shards[0], STUDY).rows) == 2 * JOB_COUNT // SHARD_COUNT
