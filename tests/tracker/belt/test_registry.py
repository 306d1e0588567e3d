from dataclasses import replace

import pytest

from tracker.belt.registry import BOX_TRACKERS, TRACKERS, get_tracker_config
from tracker.video.readings import READINGS


def test_unknown_names_list_the_valid_ones():
    with pytest.raises(ValueError, match=r"igpf.*gpf.*pf.*'ukf'"):
        get_tracker_config("ukf")


@pytest.mark.parametrize("name", TRACKERS)
def test_every_row_has_one_line_about_it(name):
    description = get_tracker_config(name).description
    assert description
    assert "\n" not in description


@pytest.mark.parametrize("table", [TRACKERS, BOX_TRACKERS], ids=["cell", "video"])
def test_filters_differ_only_in_what_the_methods_differ_in(table):
    igpf = table["igpf"]
    for name in ("pf", "gpf"):
        row = table[name]
        parts = {
            "state_space": igpf.filter.state_space,
            "proposal": igpf.filter.proposal,
            "resampling": igpf.filter.resampling,
        }
        assert replace(row.filter, **parts) == igpf.filter
        assert replace(row, filter=igpf.filter, description=igpf.description) == igpf


def test_particle_count_can_be_replaced_and_is_checked():
    assert TRACKERS["pf"].with_particle_count(30).filter.particle_count == 30
    with pytest.raises(ValueError, match="particle_count"):
        TRACKERS["pf"].with_particle_count(0)


def test_readings_differ_from_their_row_and_from_each_other():
    configs = [*READINGS.values(), BOX_TRACKERS["igpf"], BOX_TRACKERS["gpf"]]
    nameless = [replace(config, description="") for config in configs]
    assert len(set(nameless)) == len(nameless)
    for name, config in READINGS.items():
        row = BOX_TRACKERS[name.split("-")[0]]
        assert config.filter.resampling == row.filter.resampling
