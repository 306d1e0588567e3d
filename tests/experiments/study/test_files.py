"""Writes that survive a kill, and one writer in a folder."""

import os
import signal
import subprocess

import pytest
import toy_study

from experiments.study.files import append_line, exclusive, whole_lines, write_whole


def test_whole_lines_leave_out_a_torn_last_one(tmp_path):
    path = tmp_path / "file"
    assert whole_lines(path) == []
    append_line(path, "one\n")
    append_line(path, "two \u00e9\u2028\n")
    whole = path.read_bytes()
    for cut in range(len(whole) + 1):
        path.write_bytes(whole[:cut])
        expected = ["one\n", "two \u00e9\u2028\n"][: whole[:cut].count(b"\n")]
        assert whole_lines(path) == expected


@pytest.mark.parametrize("content", ["text\n", b"\x00bytes"])
def test_a_file_is_replaced_in_one_step(tmp_path, monkeypatch, content):
    path = tmp_path / "file"
    path.write_text("old")
    monkeypatch.setattr(os, "replace", lambda *_: pytest.fail("replaced"))
    monkeypatch.setattr(os, "fsync", _refuse)
    with pytest.raises(OSError, match=rf"cannot write {path}: No space left on device"):
        write_whole(path, content)
    assert path.read_text() == "old"
    monkeypatch.undo()
    write_whole(path, content)
    assert path.read_bytes() == (content if isinstance(content, bytes) else content.encode())
    assert [found.name for found in tmp_path.iterdir()] == ["file"]


def _refuse(*_):
    raise OSError(28, os.strerror(28))


def test_a_line_that_cannot_be_written_names_the_file(tmp_path):
    with pytest.raises(OSError, match=rf"cannot write {tmp_path}: Is a directory"):
        append_line(tmp_path, "x\n")


def test_a_second_writer_is_refused_until_the_first_ends(tmp_path):
    with (
        exclusive(tmp_path),
        pytest.raises(ValueError, match=rf"another run is writing to {tmp_path}; let it end first"),
        exclusive(tmp_path),
    ):
        pass
    with exclusive(tmp_path):
        pass


def test_the_lock_of_a_killed_process_is_free(tmp_path):
    code = (
        "import sys, time, pathlib; from experiments.study.files import exclusive\n"
        "with exclusive(pathlib.Path(sys.argv[1])): print('locked', flush=True); time.sleep(600)"
    )
    command = [toy_study.environment()["PYTHON"], "-c", code, str(tmp_path)]
    environment = toy_study.environment()
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"locked\n"
        with pytest.raises(ValueError, match="another run is writing"), exclusive(tmp_path):
            pass
        process.send_signal(signal.SIGKILL)
        process.wait()
    with exclusive(tmp_path):
        pass


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with (
        pytest.raises(OSError, match=r"cannot write to .*/file/out: Not a directory"),
        exclusive(tmp_path / "file" / "out"),
    ):
        pass
