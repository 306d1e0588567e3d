"""Flags that several commands have."""

import os

import pytest
from experiments.study.arguments import seed_range, split_names, worker_count


def test_names_are_split_at_commas_and_spaces_each_once():
    assert split_names(["pf,gpf", "igpf pf", ""]) == ("pf", "gpf", "igpf")


def test_seeds_begin_where_they_are_told():
    assert list(seed_range(3, 1000)) == [1000, 1001, 1002]
    with pytest.raises(ValueError, match="seeds must be 1 or greater, got 0"):
        seed_range(0)
    with pytest.raises(ValueError, match="first-seed must be 0 or greater, got -1"):
        seed_range(1, -1)


def test_there_is_a_worker_for_each_processor_that_may_be_used():
    assert worker_count(3) == 3
    assert worker_count(None) == len(os.sched_getaffinity(0))
