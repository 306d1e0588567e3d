"""Rows that belong together."""

from types import SimpleNamespace

from experiments.report.grouping import group_by, named_groups, varying

ROWS = [SimpleNamespace(a=a, b=b, seed=seed) for seed, (a, b) in enumerate(["xu", "yu", "xu"])]


def test_groups_come_in_order_of_first_appearance():
    groups = group_by(reversed(ROWS), ["b", "a"])
    seeds = [(key, [row.seed for row in members]) for key, members in groups.items()]
    assert seeds == [(("u", "x"), [2, 0]), (("u", "y"), [1])]
    assert group_by(ROWS, []) == {(): ROWS} and group_by([], ["a"]) == {}


def test_groups_are_named_by_their_keys():
    assert named_groups(ROWS, ["a"]) == [({"a": "x"}, [ROWS[0], ROWS[2]]), ({"a": "y"}, [ROWS[1]])]


def test_what_varies_has_more_than_one_value():
    assert varying(ROWS, ["b", "a", "seed"]) == ["a", "seed"]
    assert varying(ROWS[:1], ["a"]) == [] and varying([], ["a"]) == []
