from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st
from toy_study import SELECTION, STUDY

from experiments.study.manifest import Request, jobs_of
from experiments.study.shard import Shard

counts = st.integers(1, 12)


@given(counts, counts, counts)
def test_shards_are_disjoint_complete_and_evenly_mixed(cell_count, seed_count, shard_count):
    jobs = [(cell, seed) for cell in range(cell_count) for seed in range(seed_count)]
    shards = [Shard(number, shard_count).of(jobs) for number in range(1, shard_count + 1)]
    assert sorted(job for shard in shards for job in shard) == jobs
    assert all(shard == sorted(shard) for shard in shards)
    sizes = [len(shard) for shard in shards]
    assert max(sizes) - min(sizes) <= 1
    for shard in shards:
        of_cell = Counter(cell for cell, _ in shard)
        occurrences = [of_cell[cell] for cell in range(cell_count)]
        assert max(occurrences) - min(occurrences) <= 1
        if seed_count % shard_count == 0:
            assert len(shard) == cell_count * len({seed for _, seed in shard})


@pytest.mark.parametrize("text", ["0/4", "5/4", "1/0", "-1/4", "1", "1/2/3", "a/b", "", "1 /2"])
def test_what_is_no_shard_is_refused(text):
    with pytest.raises(ValueError, match=r"shard must be I/N with I from 1 to N.*got '"):
        Shard.parse(text)


def test_a_shard_is_written_as_it_is_read():
    assert str(Shard.parse("2/4")) == "2/4"
    assert Shard.parse("2/4") == Shard(2, 4)


def test_a_shard_of_a_study_has_some_of_its_jobs_in_the_order_of_the_rows():
    whole = STUDY.jobs(SELECTION)
    jobs = jobs_of(STUDY, [SELECTION], Shard(1, 2))
    assert jobs == sorted(whole[::2], key=lambda job: job.seed)
    with pytest.raises(ValueError, match="toy/sums: shard 13/13 has no sum"):
        Request.of(STUDY, SELECTION, Shard(13, 13))
