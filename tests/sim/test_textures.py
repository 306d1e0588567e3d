import numpy as np
import pytest
from dm_control import mjcf

from sim import textures
from sim.belt import artwork
from sim.belt.objects import OBJECTS


@pytest.mark.parametrize(
    "paint",
    [textures.belt_surface, textures.concrete, *(o.artwork for o in OBJECTS.values())],
)
def test_picture_is_painted_alike_every_time(paint):
    first, second = paint(), paint.__wrapped__()
    assert first.dtype == np.uint8
    assert first.shape[2] == 3
    assert not first.flags.writeable
    np.testing.assert_array_equal(first, second)


def test_carton_lid_looks_different_upside_down():
    picture = artwork.carton().astype(float)
    lid = picture[: picture.shape[0] // 4, : round(picture.shape[1] * 200 / 280)]
    turned = lid[::-1, ::-1]
    correlation = np.corrcoef(lid.mean(axis=2).ravel(), turned.mean(axis=2).ravel())[0, 1]
    assert lid.mean(axis=2).std() > 40
    assert correlation < 0.5


def test_shapes_fill_their_area():
    canvas = textures.Canvas(40.0, 20.0, 4.0, (0, 0, 0))
    canvas.rectangle(2.0, 3.0, 10.0, 5.0, (255, 255, 255))
    assert canvas.pixels[:, :, 0].sum() / 255 / 16 == pytest.approx(50.0, rel=0.02)
    canvas.disc(30.0, 10.0, 5.0, (255, 255, 255))
    assert canvas.pixels[:, 80:, 0].sum() / 255 / 16 == pytest.approx(25 * np.pi, rel=0.02)


def test_apply_gives_the_material_its_picture():
    root = mjcf.RootElement()
    material = root.asset.add("material", name="paper")
    textures.apply(root, "paper", np.zeros((4, 4, 3), np.uint8))
    assert material.texture is root.find("texture", "paper")
