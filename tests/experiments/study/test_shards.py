from collections import Counter
from dataclasses import replace

import pytest
from experiments.study.shards import Shard
from hypothesis import given
from hypothesis import strategies as st

from experiments.belt.presets import Preset, expand

counts = st.integers(1, 12)


@given(counts, counts, counts)
def test_shards_are_disjoint_complete_and_evenly_mixed(cell_count, seed_count, shard_count):
    shards = [
        Shard(number, shard_count).places(cell_count, seed_count)
        for number in range(1, shard_count + 1)
    ]
    assert sorted(place for places in shards for place in places) == list(
        range(cell_count * seed_count)
    )
    assert all(places == sorted(places) for places in shards)
    sizes = [len(places) for places in shards]
    assert max(sizes) - min(sizes) <= 1
    for places in shards:
        cells = Counter(place % cell_count for place in places)
        occurrences = [cells[cell] for cell in range(cell_count)]
        assert max(occurrences) - min(occurrences) <= 1
        if seed_count % shard_count == 0:
            assert len(places) == cell_count * len({place // cell_count for place in places})


@pytest.mark.parametrize("text", ["0/4", "5/4", "1/0", "-1/4", "1", "1/2/3", "a/b", "", "1 /2"])
def test_what_is_no_shard_is_refused(text):
    with pytest.raises(ValueError, match=r"shard must be I/N with I from 1 to N.*got '"):
        Shard.parse(text)


def test_a_shard_is_written_as_it_is_read():
    assert str(Shard.parse("2/4")) == "2/4"
    assert Shard.parse("2/4") == Shard(2, 4)


def test_a_shard_of_a_preset_has_some_of_its_trials():
    whole = Preset("p", "", expand(tracker=["pf", "igpf"]), (3, 4))
    first = replace(whole, shard=Shard(1, 2))
    assert first.trials == whole.trials[:2]
    assert first.all_trials == whole.trials
    with pytest.raises(ValueError, match="shard 5/5 of preset p is empty: there are only 4 trials"):
        replace(whole, shard=Shard(5, 5))
