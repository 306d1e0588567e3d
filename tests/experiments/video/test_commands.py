import subprocess

from experiments import cli


def beltgrasp(environment, *words):
    command = [environment["PYTHON"], "-m", "experiments.cli", *map(str, words)]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=False)


def test_run_and_report_end_to_end(root, tmp_path, toy_environment, capsys):
    out = tmp_path / "out"
    words = ["otb", "run", "--root", root, "--trackers", "gpf,pf", "--only", "One,Tow"]
    done = beltgrasp(toy_environment, *words, "--out", out, "--workers", "1")
    assert done.returncode == 1, done.stderr
    assert "beltgrasp: error: --only: no sequence or attribute 'Tow'" in done.stderr
    assert "did you mean 'Two'?" in done.stderr
    assert done.stdout.startswith("2 files")
    assert f": {out / 'rows.csv'}" in done.stdout
    assert cli.run(["report", str(out)]) == 0
    text = capsys.readouterr().out
    assert "DP OPE, n = 1" in text
    assert "corner [px]" in text
    assert f"written: {out / 'figures' / 'curves_ope.pdf'}" in text


def test_what_the_user_got_wrong_is_one_line(root, tmp_path, capsys):
    run = ["otb", "run", "--root", str(root), "--out", str(tmp_path / "out")]
    for words, expected in (
        ([*run, "--trackers", "igpf", "gfp"], "tracker must be one of igpf, gpf, pf,"),
        ([*run, "--trackers", ","], "video/otb: the selection has no file"),
        ([*run, "--protocol", "ope,all"], "protocol must be one of ope, tre, sre; got 'all'"),
        ([*run, "--workers", "0"], "workers must be 1 or greater, got 0"),
        ([*run, "--seeds", "0"], "seeds must be 1 or greater, got 0"),
        ([*run, "--list", str(tmp_path / "no.txt")], "[Errno 2] No such file"),
        (["otb", "run", "--root", "nowhere", "--out", "x"], "root must be a folder of sequences"),
        (["otb", "run"], "Missing from beltgrasp otb run"),
        (["otb"], "Expected one of {make, run}."),
        (["otb", "make", "--seeds", "2"], "a benchmark of sequences has one seed: give --seed"),
        (["otb", "make", "--only", "Nope"], "--only: no sequence or attribute 'Nope'"),
    ):
        assert cli.run(words) == 2
        captured = capsys.readouterr()
        assert captured.out == ""
        assert captured.err.startswith(f"beltgrasp: error: {expected}"), captured.err
        assert captured.err.count("\n") == 1
    assert not (tmp_path / "out").exists()
