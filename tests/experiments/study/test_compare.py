"""Two methods of results folders: which rows a side has, and by what it is judged."""

from dataclasses import dataclass, replace
from pathlib import Path

import pytest
from toy_study import SELECTION, STUDY, SumRow, run_toy

from experiments import studies
from experiments.study import compare
from experiments.study.compare import Side, verdict_lines
from experiments.study.folder import read_results


@dataclass(frozen=True)
class OtherRow(SumRow):
    """A row of the toy of another type."""


@pytest.fixture
def toy_is_known(monkeypatch):
    """`experiments.studies` finds the toy."""
    monkeypatch.setitem(studies.SUBJECTS, "toy", "toy_study")


def side(folder, method=""):
    return Side.of(folder, STUDY, read_results(folder, STUDY).rows, method)


def test_a_side_has_the_rows_of_its_method(finished):
    found = side(finished, "igpf")
    assert {row.method for row in found.rows} == {"igpf"}
    assert found.label == f"igpf ({finished})"
    assert found.scores == {seed: pytest.approx(8 + seed / 3.5) for seed in range(6)}


def test_the_only_method_need_not_be_named(tmp_path):
    run_toy(tmp_path, SELECTION | {"methods": ["pf"]})
    assert side(tmp_path).method == "pf"


def test_what_is_met_by_several_seeds_counts_once(finished):
    rows = read_results(finished, STUDY).rows
    twice = Side.of(finished, STUDY, [*rows, *rows], "pf")
    assert twice.scores == side(finished, "pf").scores


def test_a_job_that_crashed_has_no_score(tmp_path, monkeypatch):
    """A score need not know of rows without a value."""
    monkeypatch.setenv("TOY_CRASH_SEEDS", "2")
    run_toy(tmp_path)
    study = replace(STUDY, score=replace(STUDY.score, of=lambda row: (row.seed, row.value + 0.0)))
    found = Side.of(tmp_path, study, read_results(tmp_path, study).rows, "pf")
    assert [*found.scores] == [0, 1, 3, 4, 5]


def test_a_study_of_no_methods_is_refused(finished):
    study = replace(STUDY, score=None)
    with pytest.raises(ValueError, match=rf"^{finished}: toy/sums compares no methods$"):
        Side.of(finished, study, read_results(finished, study).rows, "pf")


def test_a_method_that_is_not_there_is_refused_with_those_that_are(finished):
    with pytest.raises(ValueError, match=rf"method of {finished} must be one of pf, igpf; got 'x'"):
        side(finished, "x")
    with pytest.raises(ValueError, match="must be one of pf, igpf; say which: DIR:METHOD"):
        side(finished)


def test_the_scores_of_both_are_compared_by_the_study_s_measure(finished):
    """The values are higher with the longer name, at every seed, and higher is better."""
    first, second = side(finished, "igpf"), side(finished, "pf")
    text = "\n".join(verdict_lines(first, second))
    assert text.startswith(f"{first.label} against {second.label}, value, higher is better, 6 p")
    assert f"{first.label} is better in 6, equal in 0, worse in 0" in text
    assert f"{second.label} is better in 0" in "\n".join(verdict_lines(second, first))
    study = replace(STUDY, score=replace(STUDY.score, higher_is_better=False))
    lower = [replace(one, study=study) for one in (first, second)]
    assert f"{first.label} is better in 0" in "\n".join(verdict_lines(*lower))


class TestFolders:
    """What `beltgrasp compare` and `report` take."""

    @pytest.fixture(autouse=True)
    def known(self, toy_is_known, monkeypatch):
        def labels(first, second):
            return [first.label, second.label]

        monkeypatch.setattr(compare, "verdict_lines", labels)

    def test_a_folder_and_a_method(self, finished):
        assert studies.compare(f"{finished}:pf", f"{finished}:igpf") == [
            f"pf ({finished})",
            f"igpf ({finished})",
        ]

    def test_a_method_that_is_an_import_path(self, tmp_path, finished):
        run_toy(tmp_path, SELECTION | {"methods": ["my.mod:Tracker", "pf"]})
        first, _ = studies.compare(f"{tmp_path}:my.mod:Tracker", f"{finished}:pf")
        assert first == f"my.mod:Tracker ({tmp_path})"

    def test_a_folder_whose_name_has_a_colon(self, tmp_path, finished):
        folder = tmp_path / "a:b"
        run_toy(folder, SELECTION | {"methods": ["pf"]})
        assert studies.compare(str(folder), f"{finished}:pf")[0] == f"pf ({folder})"
        assert studies.compare(f"{folder}:pf", f"{finished}:pf")[0] == f"pf ({folder})"

    def test_folders_of_two_subjects_have_nothing_in_common(self, finished, tmp_path):
        from experiments.study.manifest import Manifest

        (tmp_path / "apple").mkdir()
        Manifest("apple/tables").write(tmp_path / "apple")
        with pytest.raises(ValueError, match="apple holds no finished filter run yet"):
            studies.compare(f"{finished}:pf", f"{tmp_path / 'apple'}:kalman")

    def test_studies_with_other_rows_are_refused(self, finished, tmp_path, monkeypatch):
        """Also those of one subject."""
        others = replace(STUDY, name="toy/others", row=OtherRow)
        run_toy(tmp_path / "others", study=others)
        monkeypatch.setattr("toy_study.get_study", {"toy/sums": STUDY, "toy/others": others}.get)
        first, second = f"{finished}:pf", f"{tmp_path / 'others'}:pf"
        with pytest.raises(ValueError, match=r"holds results of toy/sums, .* of toy/others$"):
            studies.compare(first, second)

    @pytest.mark.parametrize("text", ["nowhere", "nowhere:pf", "nowhere:my.mod:It"])
    def test_a_folder_that_is_not_there(self, text):
        with pytest.raises(ValueError, match=r"nowhere holds no results: it has no manifest\.json"):
            studies.compare(text, text)

    def test_the_report_is_that_of_the_folder_s_study(self, finished):
        assert studies.rebuild_report(finished).text == "24 rows"

    def test_a_folder_of_an_unknown_study_is_refused(self, tmp_path):
        from experiments.study.manifest import Manifest

        for name, message in (
            ("dance/waltz", "subject of the study must be one of belt, .*, toy; got 'dance'"),
            ("aple/tables", "got 'aple'; did you mean 'apple'"),
            ("apple/dance", "study must be one of apple/tables, .*; got 'apple/dance'"),
            ("bearing-only/square", "study must be one of line, .*; got 'square'"),
        ):
            Manifest(name).write(tmp_path)
            with pytest.raises(ValueError, match=message):
                studies.rebuild_report(Path(tmp_path))
