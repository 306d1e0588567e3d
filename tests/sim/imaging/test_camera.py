"""The camera against geometry: projection, depth and what it refuses."""

import mujoco
import numpy as np
import pytest

from sim.imaging.camera import CAMERAS, OffscreenRenderer, get_view

WIDTH, HEIGHT = 320, 240


def scene(view, *, offsamples: int = 0, geoms: str = "") -> mujoco.MjModel:
    """A floor, two boxes and the view's camera."""
    R = view.T_world_camera[:3, :3]
    axes = " ".join(map(str, np.concatenate([R[:, 0], -R[:, 1]])))
    position = " ".join(map(str, view.position_m))
    return mujoco.MjModel.from_xml_string(f"""
    <mujoco>
      <statistic extent="2"/>
      <visual>
        <quality offsamples="{offsamples}"/><map znear="0.02" zfar="10"/>
        <headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/>
      </visual>
      <worldbody>
        <geom type="plane" size="3 3 .1" rgba=".5 .5 .5 1"/>
        <geom type="box" size=".1 .04 .04" pos=".5 -.3 .04" euler="0 0 30" rgba=".2 .4 .9 1"/>
        <geom type="box" size=".05 .2 .1" pos=".4 .3 .1" rgba=".2 .9 .4 1"/>{geoms}
        <camera name="sensor" pos="{position}" xyaxes="{axes}"
                fovy="{np.degrees(view.fovy_rad)}"/>
      </worldbody>
    </mujoco>""")


@pytest.fixture(params=list(CAMERAS))
def view(request):
    return CAMERAS[request.param]


def rendered(model: mujoco.MjModel) -> tuple[np.ndarray, np.ndarray, mujoco.MjData]:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    with OffscreenRenderer(model, WIDTH, HEIGHT) as renderer:
        rgb, depth_m = renderer.render(model, data, "sensor")
        return rgb.copy(), depth_m.copy(), data


def test_one_pass_depth_equals_ray_casts(view):
    model = scene(view)
    _, depth_m, data = rendered(model)
    K, R = view.intrinsics(WIDTH, HEIGHT), view.T_world_camera[:3, :3]
    rng = np.random.default_rng(0)
    pixels = np.column_stack([rng.integers(0, WIDTH, 400), rng.integers(0, HEIGHT, 400)])
    rays = np.column_stack([pixels, np.ones(400)]) @ np.linalg.inv(K).T
    origin = np.array(view.position_m)
    errors = []
    for (u, v), ray in zip(pixels, rays, strict=True):
        direction = R @ (ray / np.linalg.norm(ray))
        geom = np.zeros(1, np.int32)
        distance = mujoco.mj_ray(model, data, origin, direction, None, 1, -1, geom)
        errors.append(abs(distance / np.linalg.norm(ray) - depth_m[v, u]))
    assert np.median(errors) < 1e-5
    assert np.mean(np.array(errors) > 0.005) < 0.01  # a ray or two may graze a silhouette


@pytest.mark.parametrize("window", [(100, 180, 60, 200), (0, 240, 0, 320), (200, 201, 319, 320)])
def test_window_is_the_part_of_the_whole_image(view, window):
    top, bottom, left, right = window
    model = scene(view)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    with OffscreenRenderer(model, WIDTH, HEIGHT) as renderer:
        exposure = renderer.expose(model, data, "sensor")
        part = renderer.develop(exposure, (slice(top, bottom), slice(left, right)))
        whole = renderer.develop(exposure)  # after a part: it leaves the exposure as it was
    rgb, depth_m = (array[top:bottom, left:right] for array in whole)
    assert part[0].shape == rgb.shape and part[1].shape == depth_m.shape
    is_equal = (np.abs(part[0].astype(int) - rgb) <= 1).all(axis=-1) & (
        np.abs(part[1] - depth_m) < 1e-4
    )
    assert np.mean(~is_equal) < 2e-3  # an edge may fall on the other side of a pixel's centre


def test_exposure_keeps_what_was_there(view):
    model = scene(view)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    with OffscreenRenderer(model, WIDTH, HEIGHT) as renderer:
        exposure = renderer.expose(model, data, "sensor")
        before = renderer.develop(exposure)[0].copy()
        data.geom_xpos[1:] += 0.2
        model.vis.headlight.ambient[:] = 0.1
        after = renderer.develop(exposure)[0]
        now = renderer.render(model, data, "sensor")[0]
    assert np.array_equal(before, after)
    assert not np.array_equal(before, now)


def test_empty_window_has_no_pixels(view):
    model = scene(view)
    data = mujoco.MjData(model)
    with OffscreenRenderer(model, WIDTH, HEIGHT) as renderer:
        exposure = renderer.expose(model, data, "sensor")
        rgb, depth_m = renderer.develop(exposure, (slice(5, 5), slice(0, 4)))
    assert rgb.shape == (0, 4, 3) and depth_m.shape == (0, 4)


def test_intrinsics_project_a_marker_onto_its_pixels(view):
    marker = np.array([0.62, 0.21, 0.05])
    position = " ".join(map(str, marker))
    geom = f'<geom type="sphere" size=".012" pos="{position}" rgba="1 0 0 1"/>'
    rgb, _, _ = rendered(scene(view, geoms=geom))
    rows, columns = np.nonzero((rgb[..., 0] > 200) & (rgb[..., 1] < 60))
    p_camera = np.linalg.inv(view.T_world_camera) @ [*marker, 1.0]
    u, v, w = view.intrinsics(WIDTH, HEIGHT) @ p_camera[:3]
    assert columns.mean() == pytest.approx(u / w, abs=0.5)
    assert rows.mean() == pytest.approx(v / w, abs=0.5)


def test_back_projection_of_the_floor_lies_on_the_floor(view):
    model = scene(view)
    _, depth_m, _ = rendered(model)
    u, v = 20, HEIGHT - 20
    ray = np.linalg.inv(view.intrinsics(WIDTH, HEIGHT)) @ [u, v, 1.0]
    p_world = view.T_world_camera @ [*(ray * depth_m[v, u]), 1.0]
    assert p_world[2] == pytest.approx(0.0, abs=1e-4)


def test_axes_are_right_handed_and_look_at_the_belt(view):
    R = view.T_world_camera[:3, :3]
    assert np.allclose(R @ R.T, np.eye(3))
    assert np.linalg.det(R) == pytest.approx(1.0)
    towards = np.subtract(view.look_at_m, view.position_m)
    assert np.allclose(R[:, 2], towards / np.linalg.norm(towards))


def test_multisampling_is_refused_because_its_depth_is_wrong(view):
    model = scene(view, offsamples=4)
    with pytest.raises(ValueError, match="offsamples must be 0"):
        OffscreenRenderer(model, WIDTH, HEIGHT)


def test_unknown_view_lists_the_known_ones():
    with pytest.raises(ValueError, match=r"far-side, kinect, overhead; got 'farside'"):
        get_view("farside")
