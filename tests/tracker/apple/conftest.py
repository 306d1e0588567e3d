"""One maker of synthetic views for all tests of attitudes; `fruits` is importable from here."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
