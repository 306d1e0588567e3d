import hashlib
from dataclasses import replace

import pytest

from tracker.video.registry import BOX_TRACKERS, VARIANTS

COMMITTED = {
    "igpf": "059c6a901dad0557",
    "gpf": "183a5b7562cecdfb",
    "pf": "bca6a1238432d953",
    "igpf-best": "85e6c80956a13fa7",
    "igpf-patent": "aa200ce382f139be",
    "igpf-pyramid": "71fd0dc707ec0d3e",
    "gpf-subspace": "ae1fc03db3614a55",
    "pf-best": "373b4b314aa0577c",
    "gpf-best": "97f02d6851307673",
}
"""Hashes in the manifests of results/: they change with the name or a field of any settings."""


@pytest.mark.parametrize("name", COMMITTED)
def test_settings_are_those_of_the_committed_results(name):
    config = (BOX_TRACKERS | VARIANTS)[name]
    assert hashlib.sha256(repr(config).encode()).hexdigest()[:16] == COMMITTED[name]


def test_variants_differ_from_their_row_and_from_each_other():
    configs = [*VARIANTS.values(), BOX_TRACKERS["igpf"], BOX_TRACKERS["gpf"]]
    nameless = [replace(config, description="") for config in configs]
    assert len(set(nameless)) == len(nameless)
    for name, config in VARIANTS.items():
        row = BOX_TRACKERS[name.split("-")[0]]
        assert config.filter.resampling == row.filter.resampling
