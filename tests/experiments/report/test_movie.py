"""Films and captions."""

import imageio_ffmpeg
import numpy as np

from experiments.report.movie import Movie, caption


def pictures_in(path):
    reader = imageio_ffmpeg.read_frames(str(path))
    meta = next(reader)
    width, height = meta["size"]
    frames = [np.frombuffer(raw, np.uint8).reshape(height, width, 3) for raw in reader]
    return meta["fps"], frames


def test_pictures_come_back_in_their_order(tmp_path):
    levels = (20, 120, 220)
    path = tmp_path / "new" / "film.mp4"
    with Movie(path, 10) as movie:
        assert movie.is_empty and not path.parent.exists()
        for level in levels:
            movie.add(np.full((64, 96, 3), level, np.uint8))
    rate_hz, frames = pictures_in(path)
    assert rate_hz == 10
    assert [frame.shape for frame in frames] == [(64, 96, 3)] * 3
    np.testing.assert_allclose([frame.mean() for frame in frames], levels, atol=6)


def test_without_a_path_nothing_is_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with Movie(None, 10) as movie:
        movie.add(np.zeros((64, 96, 3), np.uint8))
    assert movie.is_empty and not list(tmp_path.iterdir())


def test_a_caption_darkens_a_band_and_writes_on_it():
    image = np.full((120, 640, 3), 200, np.uint8)
    caption(image, "one line")
    assert image[:36].min() < 80 and image[:36].max() > 240
    assert (image[37:] == 200).all()
