"""The code, the packages, the machine and the command that results come from."""

import importlib.metadata
import os
import platform
import subprocess
import sys
import time
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
_CODE = ("sim", "tracker", "experiments", "assets", "pyproject.toml", "uv.lock")
_PACKAGES = ("mujoco", "dm-control", "mink", "numpy", "opencv-python-headless")


@dataclass(frozen=True)
class CodeVersion:
    """The code that ran."""

    commit: str
    """Abbreviated git commit, or the package version where there is no repository."""
    is_dirty: bool
    """Whether code or assets differ from that commit."""

    def __str__(self) -> str:
        return self.commit + ("-dirty" if self.is_dirty else "")


@cache
def code_version() -> CodeVersion:
    """Commit and dirty flag of this checkout, read once per process."""
    if _git("rev-parse", "--show-toplevel") != str(ROOT):
        return CodeVersion(f"v{package_version('beltgrasp')}", is_dirty=False)
    commit = _git("rev-parse", "--short=12", "HEAD") or "uncommitted"
    return CodeVersion(commit, is_dirty=bool(_git("status", "--porcelain", "--", *_CODE)))


def provenance() -> dict[str, str]:
    """The columns of a row that name the code: `commit` and `mujoco_version`."""
    return {"commit": str(code_version()), "mujoco_version": package_version("mujoco")}


def session(worker_count: int) -> dict[str, Any]:
    """One run of a command, as the manifest keeps it: a folder that was resumed has several."""
    version = code_version()
    here = f"{Path.cwd()}{os.sep}"  # no home folder goes into the results
    return {
        "started_utc": utc_now(),
        "command": ["beltgrasp", *(word.removeprefix(here) for word in sys.argv[1:])],
        "workers": worker_count,
        "commit": version.commit,
        "is_dirty": version.is_dirty,
        "beltgrasp": package_version("beltgrasp"),
        "python": platform.python_version(),
        "packages": {name: package_version(name) for name in _PACKAGES},
        "platform": platform.platform(),
        "cpu": _cpu_model(),
        "cpu_count": os.cpu_count(),
    }


def package_version(name: str) -> str:
    """Installed version of a distribution, or `none`."""
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return "none"


def utc_now() -> str:
    """The time of now, as a manifest has it."""
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())


def _git(*arguments: str) -> str:
    """Output of a git command in the project's root; empty where git or a repository is missing."""
    command = ["git", "--no-optional-locks", "-C", str(ROOT), *arguments]
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=20.0, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return run.stdout.strip() if run.returncode == 0 else ""


def _cpu_model() -> str:
    """Name, family and model: libraries choose their kernels by them, and last digits follow."""
    try:
        lines = Path("/proc/cpuinfo").read_text().split("\n\n")[0].splitlines()
    except OSError:
        return platform.processor()
    found = {
        key.strip(): value.strip() for key, _, value in (line.partition(":") for line in lines)
    }
    if "model name" not in found:
        return platform.machine()
    kind = [f"{key} {found[key]}" for key in ("cpu family", "model") if key in found]
    return ", ".join([found["model name"], *kind])
