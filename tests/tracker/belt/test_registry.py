import pytest

from tracker.belt.registry import PEERS, TRACKERS, get_tracker_config


def test_unknown_names_list_the_valid_ones():
    with pytest.raises(ValueError, match=r"igpf.*gpf.*pf.*'ukf'"):
        get_tracker_config("ukf")


@pytest.mark.parametrize("name", [*TRACKERS, *PEERS])
def test_every_row_has_one_line_about_it(name):
    description = get_tracker_config(name).description
    assert description
    assert "\n" not in description


def test_particle_count_can_be_replaced_and_is_checked():
    assert TRACKERS["pf"].with_particle_count(30).filter.particle_count == 30
    with pytest.raises(ValueError, match="particle_count"):
        TRACKERS["pf"].with_particle_count(0)
