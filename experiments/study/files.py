"""Writes that survive a kill: whole files replaced in one step, whole lines appended and synced."""

import contextlib
import fcntl
import os
from collections.abc import Generator
from pathlib import Path


def append_line(path: Path, line: str) -> None:
    """Adds one whole line by a single write and waits until it is on the disk.

    A kill leaves at most one torn last line, without a line end, which `whole_lines` leaves out.
    """
    data = line.encode()
    with _naming(path), path.open("ab", buffering=0) as file:
        while data:  # a disk that takes a part says why at the rest
            data = data[file.write(data) :]
        os.fsync(file.fileno())


def whole_lines(path: Path) -> list[str]:
    """The complete lines of a file that may not exist, with their line ends."""
    if not path.exists():
        return []
    data = path.read_bytes()
    return [line + "\n" for line in data[: data.rfind(b"\n") + 1].decode().split("\n")[:-1]]


def write_whole(path: Path, content: str | bytes) -> None:
    """Replaces the file in one step, so that a kill leaves the old or the new one, whole."""
    new = path.with_name(f".{path.name}.new")
    with _naming(path):
        with new.open("wb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(new, path)


@contextlib.contextmanager
def exclusive(folder: Path) -> Generator[None, None, None]:
    """Keeps a second writer out of the folder; the lock ends with the process, however it ends."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = (folder / ".lock").open("w")
    except OSError as error:
        raise OSError(f"cannot write to {folder}: {error.strerror}") from error
    with lock as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise ValueError(f"another run is writing to {folder}; let it end first") from None
        yield


@contextlib.contextmanager
def _naming(path: Path) -> Generator[None, None, None]:
    """Puts the name of the file into an error of the system."""
    try:
        yield
    except OSError as error:
        raise OSError(f"cannot write {path}: {error.strerror}") from error
