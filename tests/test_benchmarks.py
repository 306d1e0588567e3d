"""Benchmarks are run by hand and by nobody else: here at least that they can be."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def test_every_benchmark_is_collected():
    command = [sys.executable, "-m", "pytest", "benchmarks", "--collect-only", "-q"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    for path in (ROOT / "benchmarks").glob("test_*.py"):
        assert f"{path.name}::" in done.stdout
