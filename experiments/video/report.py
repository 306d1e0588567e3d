"""Rebuilds every table and figure of a folder of OTB results from its boxes and the truth."""

from __future__ import annotations

from pathlib import Path

from experiments.belt.report import Report
from experiments.report.table import Table, write_tables
from experiments.video.results import OtbResults, read_results
from experiments.video.tables import affine_table, attribute_table, score_table, sequence_table


def write_report(folder: Path, root: Path | None = None, pictures: bool = False) -> Report:
    """Writes `tables/` and `figures/` into `folder`.

    Args:
        folder: Results of `beltgrasp otb run`, finished or not.
        root: Folder of the sequences; the manifest's if not given.
        pictures: Also a strip of images with boxes, for which the sequences' images are read.
    """
    results = read_results(folder, root)
    from experiments.video.figures import write_figures

    tables = _tables(results)
    paths = write_tables(folder / "tables", tables)
    paths += write_figures(folder / "figures", results)
    if pictures:
        from experiments.video.pictures import write_strip

        paths += write_strip(folder / "figures", results, results.root)
    shown = [
        tables[name].to_text() for name in ("precision", "overlap", "affine") if name in tables
    ]
    return Report("\n".join([*shown, *_notes(results)]), tuple(paths))


def _tables(results: OtbResults) -> dict[str, Table]:
    tables = {
        "precision": score_table(results, "dp"),
        "overlap": score_table(results, "os"),
        "sequences": sequence_table(results),
        "attributes": attribute_table(results, "ope"),
        "affine": affine_table(results),
    }
    return {name: table for name, table in tables.items() if table is not None}


def _notes(results: OtbResults) -> list[str]:
    return [
        f"{protocol}: left out, as not every tracker has finished them: {', '.join(left_out)}\n"
        for protocol in results.protocols
        if (left_out := results.left_out(protocol))
    ]
