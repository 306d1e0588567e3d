"""What determines a row beside its job: what is described, and how a difference is said."""

import enum
import functools
import json
import math
import subprocess
from dataclasses import dataclass, field

import numpy as np
import pytest
import toy_study

from experiments.study.files import write_whole
from experiments.study.settings import describe, merge


@dataclass(frozen=True)
class Inner:
    gain: float = 0.1
    count: int = 3


@dataclass(frozen=True)
class Outer:
    name: str = "x"
    inner: Inner = Inner()
    weights: np.ndarray = field(default_factory=lambda: np.arange(6.0).reshape(2, 3))
    rates: tuple[float, ...] = (1.0, 2.0)
    description: str = "for people"


class Colour(enum.Enum):
    RED = 1


def test_a_description_is_json_and_comes_back_equal():
    values = {"outer": Outer(), "none": None, "flag": True, "nan": math.nan, "big": 10**30}
    found = describe(values)
    assert json.loads(json.dumps(found, allow_nan=False)) == found
    assert found["outer"]["inner"] == {"gain": "0.1", "count": 3}
    assert found["outer"]["rates"] == ["1.0", "2.0"]
    assert "description" not in found["outer"]


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (Colour.RED, "RED"),
        (math.hypot, "math.hypot"),
        (write_whole, "write_whole"),
        (ValueError, "builtins.ValueError"),
        (functools.partial(math.pow, 2.0), ["math.pow", ["2.0"], {}]),
        (0.1 + 0.2, "0.30000000000000004"),
        (np.float64(0.1 + 0.2), "0.30000000000000004"),
        (np.float32(0.1), describe(float(np.float32(0.1)))),
        (np.int64(3), 3),
        (np.True_, True),
    ],
)
def test_what_is_no_data_has_a_name(value, text):
    assert describe(value) == text


@pytest.mark.parametrize(
    "other",
    [
        Outer(inner=Inner(gain=0.1 + 1e-17 + 1e-16)),
        Outer(weights=np.arange(6.0)),
        Outer(weights=np.arange(6.0).reshape(2, 3) + np.eye(2, 3) * 1e-12),
        Outer(rates=(1.0, 2.5)),
        Outer(rates=(1.0,)),
    ],
)
def test_every_digit_and_shape_counts(other):
    assert describe(other) != describe(Outer())
    assert describe(Outer(description="in other words")) == describe(Outer())


def test_arrays_count_by_their_values_not_by_how_they_lie_in_memory():
    array = np.arange(6.0).reshape(2, 3)
    assert describe(np.asfortranarray(array)) == describe(array)
    assert describe(array.astype(np.float32)) != describe(array)


def test_a_function_from_outside_the_project_counts_by_its_source():
    """Of the project's own the commit says which it is."""
    name, _, source = describe(Inner).partition(" ")
    assert (name, len(source)) == ("Inner", 16)
    assert describe(Outer) != describe(Inner)
    assert source not in describe(Outer)


def test_files_count_by_their_content(tmp_path):
    one, two, other = (tmp_path / name for name in ("one", "two", "other"))
    for path, text in ((one, "same"), (two, "same"), (other, "else")):
        path.write_text(text)
    assert describe(one) == describe(two) != describe(other)


def test_the_order_of_a_set_does_not_count():
    """It is another one in every process."""
    code = "from experiments.study.settings import describe; print(describe({'a', 'b', 'c', 'd'}))"
    found = set()
    for seed in ("1", "2", "3"):
        environment = toy_study.environment() | {"PYTHONHASHSEED": seed}
        command = [environment["PYTHON"], "-c", code]
        found.add(subprocess.run(command, env=environment, capture_output=True, check=True).stdout)
    assert len(found) == 1


def test_what_has_no_description_of_its_own_is_refused():
    """Its name in memory would be another one in every process."""
    with pytest.raises(ValueError, match="settings must be data, files or functions, got <object"):
        describe({"thing": object()})


def test_what_is_new_is_added_and_what_is_kept_stays():
    kept = merge({}, {"a": Inner(), "b": 1})
    assert merge(kept, {"c": 2.0}) == kept | {"c": "2.0"}
    assert merge(kept, {"a": Inner()}) == kept
    assert merge(json.loads(json.dumps(kept)), {"a": Inner(), "b": 1}) == kept


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        ({"b": 2}, "other settings: b was 1, is 2"),
        ({"b": None}, "other settings: b was 1, is None"),
        ({"a": Outer(inner=Inner(gain=0.2))}, "other settings: a.inner.gain was 0.1, is 0.2"),
        ({"a": Outer(name="y"), "b": 2}, "other settings: a.name was x, is y; b was 1, is 2"),
        ({"a": Inner()}, "other settings: a.name was x, is None; a.inner was {'gain'.* and 2 more"),
    ],
)
def test_what_differs_is_named_with_its_place_in_one_line(wanted, message):
    kept = merge({}, {"a": Outer(), "b": 1})
    before = json.dumps(kept)
    with pytest.raises(ValueError, match=f"^{message}") as refusal:
        merge(kept, wanted)
    assert "\n" not in str(refusal.value)
    assert json.dumps(kept) == before
