import cv2
import numpy as np
import pytest

from experiments.video import tb50
from experiments.video.sequences import SequenceError, find_sequences, load_sequence, read_boxes
from experiments.video.tb50 import ATTRIBUTES, NO_START, TB50_ATTRIBUTES


def load(root, name="One"):
    return load_sequence(name, find_sequences(root)[name])


def edit(path, line, text):
    lines = path.read_text().splitlines()
    lines[line - 1] = text
    path.write_text("\n".join(lines) + "\n")


def test_a_sequence_has_images_boxes_and_challenges(root):
    sequence = load(root)
    assert len(sequence) == 8
    assert sequence.boxes[1].tolist() == [13, 14, 20, 16]
    assert sequence.size_px == (64, 48)
    assert sequence.image(7).shape == (48, 64, 3)
    assert sequence.attributes == ("SV", "FM")
    assert sequence.affine is not None
    assert load(root, "Two").affine is None
    assert load(root, "Two").attributes == ()


@pytest.mark.parametrize("line", ["1,2,3,4", "1\t2\t3\t4", " 1  2 3   4 ", "1, 2, 3, 4,"])
def test_boxes_are_separated_by_commas_tabs_or_blanks(tmp_path, line):
    path = tmp_path / "groundtruth_rect.txt"
    path.write_text(f"{line}\r\nNaN NaN NaN NaN\n\n")
    boxes = read_boxes(path)
    assert boxes[0].tolist() == [1, 2, 3, 4]
    assert np.isnan(boxes[1]).all()


@pytest.mark.parametrize("line", ["", "1,2,3", "5", "1,2,3,4,5", "a,b,c,d", "1,2,inf,4"])
def test_a_line_that_is_no_box_is_named(root, line):
    path = root / "One" / "groundtruth_rect.txt"
    edit(path, 3, line)
    with pytest.raises(SequenceError, match=r"groundtruth_rect.txt, line 3: not a box x y w h"):
        load(root)


def test_images_after_the_last_box_do_not_count(root):
    path = root / "One" / "groundtruth_rect.txt"
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:6]))
    (root / "One" / "affine.csv").unlink()
    sequence = load(root)
    assert (len(sequence), len(sequence.image_paths), sequence.spare_image_count) == (6, 6, 2)


def test_the_images_that_the_benchmark_cuts_are_cut_at_both_ends(root, monkeypatch):
    monkeypatch.setitem(tb50.FIRST_IMAGE, "Two", 3)
    monkeypatch.setitem(tb50.LAST_IMAGE, "Two", 7)
    path = root / "Two" / "groundtruth_rect.txt"
    path.write_text("".join(path.read_text().splitlines(keepends=True)[2:7]))
    sequence = load(root, "Two")
    assert [p.name for p in sequence.image_paths] == [f"000{k}.png" for k in range(3, 8)]
    assert sequence.spare_image_count == 0


def test_missing_images_are_an_error(root):
    (root / "One" / "img" / "0008.png").unlink()
    with pytest.raises(SequenceError, match=r"line 8: 8 boxes, but .*img holds 7 images"):
        load(root)


def test_a_folder_without_images_or_ground_truth_is_an_error(root):
    (root / "Bare" / "img").mkdir(parents=True)
    (root / "Blind").mkdir()
    (root / "Blind" / "groundtruth_rect.txt").write_text("1,1,5,5\n")
    with pytest.raises(SequenceError, match=r"Bare/groundtruth_rect.txt: No such file"):
        load(root, "Bare")
    with pytest.raises(SequenceError, match="Blind/img: no such folder"):
        load(root, "Blind")


def test_a_root_without_sequences_is_an_error(tmp_path):
    with pytest.raises(SequenceError, match="must be a folder of sequences; got"):
        find_sequences(tmp_path / "nowhere")
    with pytest.raises(SequenceError, match="holds none"):
        find_sequences(tmp_path)


def test_a_folder_of_two_targets_is_two_sequences(root):
    folder = root / "Two"
    (folder / "groundtruth_rect.txt").rename(folder / "groundtruth_rect.1.txt")
    (folder / "groundtruth_rect.2.txt").write_text("1,1,5,5\n" * 8)
    assert list(find_sequences(root)) == ["One", "Two-1", "Two-2"]
    assert load(root, "Two-2").boxes[0].tolist() == [1, 1, 5, 5]


def test_damaged_images_are_named(root):
    folder = root / "One" / "img"
    sequence = load(root)
    whole = (folder / "0003.png").read_bytes()
    (folder / "0003.png").write_bytes(whole[: len(whole) // 2])
    (folder / "0004.png").write_text("no image")
    (folder / "0005.png").write_bytes(b"")
    for index in (2, 3, 4):
        with pytest.raises(SequenceError, match=rf"000{index + 1}\.png: "):
            sequence.image(index)


def test_a_jpeg_that_was_cut_short_is_named(root):
    path = root / "One" / "img" / "0003.png"
    data = cv2.imencode(".jpg", cv2.imread(str(path)))[1].tobytes()
    path.write_bytes(data)
    assert load(root).image(2).shape == (48, 64, 3)
    path.write_bytes(data[:-100])
    with pytest.raises(
        SequenceError, match=r"0003\.png: the image is cut short|0003\.png: not a readable"
    ):
        load(root).image(2)


def test_an_image_of_another_size_is_named(root):
    cv2.imwrite(str(root / "One" / "img" / "0005.png"), np.zeros((10, 20, 3), np.uint8))
    with pytest.raises(SequenceError, match=r"0005.png: 20 x 10 px, but the first image has 64 x"):
        load(root).image(4)


def test_an_unknown_challenge_is_named(root):
    (root / "One" / "attrs.txt").write_text("SV\nXX\n")
    with pytest.raises(SequenceError, match=r"attrs.txt, line 2: attribute must be one of IV, SV"):
        load(root)


def test_stretches_without_starts_are_frames_of_the_sequence(root):
    (root / "One" / "init_omit.txt").write_text("3 4\n7 9\n")
    assert load(root).no_start == ((3, 4), (7, 9))
    (root / "One" / "init_omit.txt").write_text("3\n")
    with pytest.raises(SequenceError, match=r"init_omit.txt, line 1: two image numbers"):
        load(root)


def test_the_lists_of_the_benchmark_are_whole():
    assert len(TB50_ATTRIBUTES) == 50
    counts = {a: sum(a in tags for tags in TB50_ATTRIBUTES.values()) for a in ATTRIBUTES}
    assert counts == dict(
        IV=22, SV=38, OCC=29, DEF=23, MB=20, FM=27, IPR=29, OPR=32, OV=11, BC=20, LR=10
    )
    assert set(NO_START) <= {name.lower() for name in TB50_ATTRIBUTES}


def test_affine_truth_is_read_and_checked(root):
    truth = load(root).affine
    assert truth.warps.shape == (8, 3, 3)
    assert truth.warps[0, :2, 2].tolist() == [19.5, 19.5]
    assert truth.corners[0].tolist() == [[9.5, 11.5], [29.5, 11.5], [29.5, 27.5], [9.5, 27.5]]
    path = root / "One" / "affine.csv"
    for line, text, message in (
        (4, "9,1,0,0,1,0,0,1", "line 4: .* of frame 3 expected, got 9,1"),
        (4, "3,1,0,0,1,0,0", "line 4: .* of frame 3 expected"),
        (4, "3,1,0,0,-1,0,0,1", "line 4: the warp's determinant must be positive"),
        (1, "frame,x", "line 1: the header must be"),
    ):
        whole = path.read_text()
        edit(path, line, text)
        with pytest.raises(SequenceError, match=message):
            load(root)
        path.write_text(whole)
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:5]))
    with pytest.raises(SequenceError, match=r"line 6: .* of frame 5 expected, got nothing"):
        load(root)
