"""What a study is: jobs, what one job leaves, and all that the mechanism must know of both.

A study is described once, by a `Study`; `run`, `films`, `merge` and the commands do the rest in
the same way for every one of them.
"""

import importlib
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from pathlib import Path
from typing import Any, Generic, TypeAlias, TypeVar

from experiments.report.table import format_cell

Job = TypeVar("Job")
Row = TypeVar("Row")

Selection: TypeAlias = dict[str, Any]
"""Which jobs of a study are asked for, as JSON holds it: methods, seeds, settings."""

Key: TypeAlias = tuple[str, ...]
"""Names a job: the cells of the study's key columns."""


@dataclass(frozen=True)
class Result(Generic[Row]):
    """What one job left."""

    rows: tuple[Row, ...]
    timings: Any = None
    """A row of the study's `timings`; None where the study times nothing but the whole job."""
    curves: Mapping[str, str] = field(default_factory=dict[str, str])
    """Name of a file of curves -> lines of it, each of which begins with the key."""
    files: Mapping[str, str | bytes] = field(default_factory=dict[str, str | bytes])
    """Path in the results folder -> content, of what is kept beside the rows."""
    error: str | None = None
    """Traceback of a job that crashed."""
    wall_s: float = 0.0


@dataclass(frozen=True, eq=False)
class Results(Generic[Row]):
    """What a folder holds, of a study that is finished or not, in the order of its jobs."""

    path: Path
    rows: list[Row]
    timings: list[Any]
    """Rows of the study's `timings`; empty where it has none."""
    curves: dict[str, dict[Key, str]]
    """Name of a file of curves -> the lines of each job that has any."""

    @cached_property
    def good(self) -> list[Row]:
        """The rows without those of jobs that crashed."""
        rows: list[Any] = self.rows
        return [row for row in rows if row.outcome != "error"]

    @property
    def notes(self) -> list[str]:
        """A line that says how many jobs crashed, if any did."""
        count = len(self.rows) - len(self.good)
        return [f"left out: {count} that crashed; the same command tries them again"] * (count > 0)


@dataclass(frozen=True)
class Score:
    """By what two methods of a study are compared, job by job."""

    of: Callable[[Any], tuple[Hashable, float] | None]
    """Row -> what both methods met, and how good the method was there; None leaves the row out."""
    name: str
    """What it measures, with its unit."""
    higher_is_better: bool


def as_they_come(job: Any) -> int:
    """The order of jobs that need no other: that in which the study names them."""
    del job
    return 0


def never(rows: Sequence[Any]) -> bool:
    """No job of the study is a failure."""
    del rows
    return False


def fields_of(job: Any) -> dict[str, Any]:
    """The fields of a job by name."""
    return {field.name: getattr(job, field.name) for field in fields(job)}


@dataclass(frozen=True)
class Study(Generic[Job, Row]):
    """A study: what it runs, what a row is, and how results are shown.

    Workers are given the whole study, so its functions are those of modules, which can be pickled.
    """

    name: str
    """`subject/study`, as the manifest has it."""
    unit: str
    """What a job is called: trial, flight, world."""
    row: type[Row]
    """A frozen dataclass of scalars with the columns `outcome` and `detail`."""
    key: tuple[str, ...]
    """Columns of the row, of the timings and of the curves that name its job."""
    jobs: Callable[[Selection], Sequence[Job]]
    """All jobs of a selection, cell by cell; ValueError for what there is not."""
    work: str
    """Import path `module:function` of what a worker does: jobs -> a result for each."""
    settings: Callable[[Job], Mapping[str, object]]
    """Name -> object of everything that determines the rows of a job beside its own fields."""
    report: str
    """Import path of what writes tables and figures: Results -> Report."""
    title: Callable[[Job], str]
    """The job in a few words."""
    method: str = ""
    """The column that names what is compared: tracker, controller, method."""
    score: Score | None = None
    """By what two methods are compared; None where there is nothing to compare."""
    compare: str = "experiments.study.compare:verdict_lines"
    """Import path of what compares two methods: (side, side) -> lines of text."""
    order: Callable[[Job], Any] = as_they_come
    """Sorts the jobs into the order of their rows; equal ones stay in the order of `jobs`."""
    identity: Callable[[Job], Mapping[str, Any]] = fields_of
    """The columns of a row that are known before the job has run; the key among them."""
    timings: type[Any] | None = None
    """Row of `timings.csv` with the key and `wall_s`; None for these alone."""
    curves: Mapping[str, str] = field(default_factory=dict[str, str])
    """Name -> header of each `NAME.csv.gz`: what is measured many times a job."""
    together: Callable[[Job], Hashable] | None = None
    """Jobs for which this is equal and not None are run at once."""
    needs_rendering: bool = False
    """Whether its jobs make images, so that a machine that cannot is refused at once."""
    is_failure: Callable[[Sequence[Row]], bool] = never
    """Whether the rows of a job are of a failure, which `--video failures` films."""
    film: str = ""
    """Import path of what films a job again: (job, path) -> the outcome, to hold against the
    row's, or None; empty where there is nothing to film."""

    def key_of(self, job: Job) -> Key:
        """The cells that name a job."""
        known = self.identity(job)
        return tuple(format_cell(known[name]) for name in self.key)


def load(path: str) -> Callable[..., Any]:
    """What stands at the import path `module:function`; imported when it is asked for."""
    module, _, name = path.partition(":")
    return getattr(importlib.import_module(module), name)
