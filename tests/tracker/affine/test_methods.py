from dataclasses import asdict, replace

import pytest

from tracker.affine.filter import FilterConfig
from tracker.affine.methods import METHODS
from tracker.belt.registry import TRACKERS
from tracker.video.registry import BOX_TRACKERS

PARTS = {
    "igpf": ("group", "gaussian", "improved-gaussian"),
    "gpf": ("group", "gaussian", "residual"),
    "pf": ("vector", "prior", "systematic"),
}


@pytest.mark.parametrize("name", METHODS)
def test_a_method_sets_its_own_parts_and_no_other(name):
    before = FilterConfig(particle_count=33, autoregression=0.25)
    after = METHODS[name].applied_to(before)
    changed = {field for field, value in asdict(after).items() if value != asdict(before)[field]}
    assert changed <= {"state_space", "proposal", "resampling"}
    assert (after.state_space, after.proposal, after.resampling) == PARTS[name]


@pytest.mark.parametrize("table", [TRACKERS, BOX_TRACKERS], ids=["belt", "video"])
@pytest.mark.parametrize("name", METHODS)
def test_rows_of_the_comparison_differ_only_in_what_the_methods_differ_in(table, name):
    row, igpf = table[name], table["igpf"]
    assert row.filter == METHODS[name].applied_to(igpf.filter)
    assert replace(row, filter=igpf.filter, description=igpf.description) == igpf
    assert row.description == METHODS[name].description
