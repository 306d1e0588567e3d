"""Corners on pictures whose motion is known."""

import cv2
import numpy as np
import pytest

from tracker.bearing_only.corners import SLOT_PX, CornerConfig, CornerTracker, PatchStore

HEIGHT, WIDTH = 240, 320


@pytest.fixture(scope="module")
def wall() -> np.ndarray:
    """(h, w) uint8 wall, larger than the images, with dark and light polygons."""
    rng = np.random.default_rng(0)
    picture = np.full((2 * HEIGHT, 2 * WIDTH), 120, np.uint8)
    for y in range(20, 2 * HEIGHT, 40):
        for x in range(20, 2 * WIDTH, 40):
            points = np.add([x, y], rng.uniform(-14, 14, (3, 2)))
            shade = int(rng.choice([20, 60, 200, 240]))
            cv2.fillPoly(picture, [np.int32(16 * points)], shade, cv2.LINE_AA, 4)
    return cv2.GaussianBlur(picture, (0, 0), 0.8)


def view(wall, left: float, top: float, scale: float = 1.0) -> np.ndarray:
    """(h, w) image: (left, top) of the wall is in the middle of its first pixel."""
    M = np.array([[1 / scale, 0, left], [0, 1 / scale, top]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(wall, M, (WIDTH, HEIGHT), flags=flags)


def test_ids_and_places_over_a_long_way(wall):
    """Sub-pixel steps: every corner moves as the picture does, and keeps its name."""
    corners = CornerTracker()
    first = corners.update(view(wall, 100.0, 80.0))
    start = dict(zip(first.ids.tolist(), first.pixels, strict=True))
    assert len(start) > 30
    for step in range(1, 41):
        seen = corners.update(view(wall, 100.0 + 0.7 * step, 80.0 - 0.35 * step))
    kept = [
        (pixel, start[i])
        for i, pixel in zip(seen.ids.tolist(), seen.pixels, strict=True)
        if i in start
    ]
    assert len(kept) > 20
    moved = np.array([now - then for now, then in kept])
    assert np.abs(moved - [-28.0, 14.0]).max() < 0.25


def test_places_are_those_of_the_wall(wall):
    """Pixel coordinates start at the edge of the image, half a pixel before its first pixel."""
    picture = np.full((HEIGHT, WIDTH), 200, np.uint8)
    picture[100:, 150:] = 30
    corner = CornerTracker(CornerConfig(count=1)).update(picture).pixels
    assert np.abs(corner - [150.0, 100.0]).max() <= 1.0


def test_a_growing_picture_is_followed(wall):
    corners = CornerTracker()
    first = corners.update(view(wall, 100, 80))
    for step in range(1, 31):
        scale = 1.015**step
        middle = np.array([100 + WIDTH / 2, 80 + HEIGHT / 2])
        left, top = middle - np.array([WIDTH, HEIGHT]) / 2 / scale
        seen = corners.update(view(wall, left, top, scale))
    on_wall = (seen.pixels - 0.5) / scale + [left, top]
    before = first.pixels - 0.5 + [100, 80]
    kept = np.isin(seen.ids, first.ids)
    assert kept.sum() > 8
    off_px = scale * np.abs(on_wall[kept] - before[seen.ids[kept]])
    assert np.median(off_px) < 0.8 and off_px.max() < 1.5


def test_names_are_never_given_twice(wall):
    corners, names, last = CornerTracker(), set(), set()
    for step in range(30):
        now = set(corners.update(view(wall, 20.0 + 8.0 * step, 80.0)).ids.tolist())
        assert not (now - last) & names
        names |= now
        last = now
    assert len(names) > 60


def test_corners_keep_their_distance_and_the_margin(wall):
    config = CornerConfig(count=30, spacing_px=25.0, margin_px=20)
    pixels = CornerTracker(config).update(view(wall, 50, 50)).pixels - 0.5
    gaps = np.linalg.norm(pixels[:, None] - pixels, axis=2)[np.triu_indices(len(pixels), 1)]
    assert gaps.min() >= 25.0
    assert (pixels >= 20).all() and (pixels < [WIDTH - 20, HEIGHT - 20]).all()


def test_nothing_is_seen_in_the_part_to_avoid(wall):
    corners, avoid = CornerTracker(), (100, 60, 80, 90)
    for step in range(6):
        pixels = corners.update(view(wall, 60.0 + 3.0 * step, 70.0), avoid).pixels - 0.5
        is_in = ((pixels >= [100, 60]) & (pixels < [180, 150])).all(axis=1)
        assert len(pixels) and not is_in.any()


def test_what_is_hidden_is_dropped(wall):
    corners = CornerTracker(CornerConfig(refill=0.0))
    first = corners.update(view(wall, 60, 60))
    image = view(wall, 61, 60)
    image[:, 160:] = 128
    seen = corners.update(image)
    assert 5 < len(seen.ids) < len(first.ids)
    assert (seen.pixels[:, 0] < 160).all()


def test_an_empty_image_has_no_corner():
    corners = CornerTracker()
    for _ in range(3):
        assert len(corners.update(np.full((HEIGHT, WIDTH), 90, np.uint8)).ids) == 0


def test_after_darkness_all_corners_are_new(wall):
    corners = CornerTracker()
    first = corners.update(view(wall, 60, 60))
    corners.update(np.zeros((HEIGHT, WIDTH), np.uint8))
    again = corners.update(view(wall, 60, 60))
    assert len(again.ids) and not np.isin(again.ids, first.ids).any()


def test_images_that_do_not_fit_are_refused(wall):
    corners = CornerTracker()
    with pytest.raises(ValueError, match="uint8"):
        corners.update(np.zeros((HEIGHT, WIDTH, 3), np.uint8))
    with pytest.raises(ValueError, match="uint8"):
        corners.update(np.zeros((HEIGHT, WIDTH), np.float32))
    corners.update(view(wall, 0, 0))
    with pytest.raises(ValueError, match="alike"):
        corners.update(view(wall, 0, 0)[:-1])
    with pytest.raises(ValueError, match=r"count must be 4 or fewer.*40"):
        CornerTracker().update(np.zeros((64, 64), np.uint8))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"count": 0}, "count"),
        ({"window_px": 14}, "window_px.*14"),
        ({"window_px": 33}, "window_px.*33"),
        ({"refill": 1.5}, "refill"),
        ({"return_px": 0.0}, "return_px"),
        ({"spacing_px": float("nan")}, "spacing_px"),
    ],
)
def test_impossible_settings_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        CornerConfig(**change)


def test_the_album_keeps_what_it_is_given(wall):
    image = view(wall, 30, 40)
    store = PatchStore((HEIGHT, WIDTH))
    assert len(store) == (HEIGHT // SLOT_PX) * (WIDTH // SLOT_PX)
    store.keep(11, image, np.float32([101.0, 77.0]))
    x, y = store.centres_px[11].astype(int)
    half = SLOT_PX // 2 - 1
    kept = store.picture[y - half : y + half + 1, x - half : x + half + 1]
    assert np.array_equal(kept, image[77 - half : 77 + half + 1, 101 - half : 101 + half + 1])
    assert np.count_nonzero(store.picture) == np.count_nonzero(kept)
