"""What the benchmark tells about its own sequences; numbers of images are those in their names.

`tb50.csv` has a line for each sequence with exceptions or challenges. Source: the lists beside the
reference code of [OTB2015].
"""

import csv
from pathlib import Path

ATTRIBUTES = {
    "IV": "illumination variation",
    "SV": "scale variation",
    "OCC": "occlusion",
    "DEF": "deformation",
    "MB": "motion blur",
    "FM": "fast motion",
    "IPR": "in-plane rotation",
    "OPR": "out-of-plane rotation",
    "OV": "out of view",
    "BC": "background clutter",
    "LR": "low resolution",
}
"""The eleven challenges by which the benchmark groups its sequences."""

with Path(__file__).with_suffix(".csv").open(encoding="utf-8", newline="") as _file:
    _ROWS = list(csv.DictReader(_file))

TB50_ATTRIBUTES = {r["name"]: tuple(r["attributes"].split()) for r in _ROWS if r["attributes"]}
"""The fifty sequences of TB-50 and their challenges."""

FIRST_IMAGE = {row["name"]: int(row["first_image"]) for row in _ROWS if row["first_image"]}
"""The image of the first box, where it is not the first image."""

LAST_IMAGE = {row["name"]: int(row["last_image"]) for row in _ROWS if row["last_image"]}
"""The image of the last box, where it is not the last image."""

NO_START = {row["name"].lower(): row["no_start"] for row in _ROWS if row["no_start"]}
"""First and last images of the stretches in which no run of TRE may start (`initOmit`), by the
name in lower case; the target is hidden or out of view there. Sequences that are not listed have
none in the reference code of 2013; those added later bring theirs in `init_omit.txt`."""
