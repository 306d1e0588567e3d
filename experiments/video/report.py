"""Rebuilds every table and figure of trackers on video from their rows and curves."""

from experiments.report.report import Report
from experiments.study.study import Results
from experiments.video.job import VideoRow
from experiments.video.results import OtbResults
from experiments.video.tables import affine_table, attribute_table, score_table, sequence_table

_SHOWN = ("precision", "overlap", "affine")


def write_report(results: Results[VideoRow]) -> Report:
    """Writes `tables/` and `figures/`, and a strip of images where the sequences are there."""
    from experiments.video.figures import write_figures

    videos = OtbResults.collect(results)
    tables = {
        "precision": score_table(videos, "dp"),
        "overlap": score_table(videos, "os"),
        "sequences": sequence_table(videos),
        "attributes": attribute_table(videos, "ope"),
        "affine": affine_table(videos),
    }
    figures = write_figures(results.path / "figures", videos)
    notes = [
        f"{protocol}: left out, as not every tracker has finished them: {', '.join(left_out)}\n"
        for protocol in videos.protocols
        if (left_out := videos.left_out(protocol))
    ]
    return Report.of(results.path, tables, figures, _SHOWN, [*results.notes, *notes])
