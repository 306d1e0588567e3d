"""A small synthetic conveyor scene: textured box top on a textured belt, seen in perspective."""

import functools
import math
from dataclasses import dataclass

import cv2
import numpy as np

SIZE_M = (0.20, 0.08)
TOP_Z_M = 0.08
BELT_Y0_M, BELT_X0_M, SHEET_M_PER_PX = -1.3, 0.25, 0.001


def far_side_camera(width: int = 640, height: int = 480) -> tuple[np.ndarray, np.ndarray]:
    """K and T_world_camera of the default view."""
    focal = 0.5 * height / math.tan(math.radians(25))
    K = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1]])
    return K, look_at((1.5, 0.0, 1.15), (0.5, 0.0, 0.0))


def look_at(position, target, up=(0.0, 0.0, 1.0)) -> np.ndarray:
    z = np.subtract(target, position)
    z = z / np.linalg.norm(z)
    x = np.cross(z, up)
    x /= np.linalg.norm(x)
    T = np.eye(4)
    T[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    T[:3, 3] = position
    return T


def pixel_of_world(view, point_m) -> np.ndarray:
    """(..., 2) overhead pixels (column, row) of world points (..., 2 or 3) on the plane."""
    point_m = np.asarray(point_m, float)
    column = (point_m[..., 1] - view.y_range_m[0]) / view.m_per_px
    row = (point_m[..., 0] - view.x_range_m[0]) / view.m_per_px
    return np.stack([column, row], axis=-1)


@functools.cache
def box_picture(seed: int = 3) -> np.ndarray:
    """(160, 400) uint8 carton artwork, different under a half turn."""
    rng = np.random.default_rng(seed)
    picture = np.full((160, 400), 165, np.uint8)
    picture = (picture + cv2.GaussianBlur(rng.normal(0, 40, picture.shape), (0, 0), 6)).clip(0, 255)
    picture = picture.astype(np.uint8)
    cv2.rectangle(picture, (20, 20), (130, 140), 60, -1)
    cv2.circle(picture, (80, 80), 36, 230, -1)
    cv2.putText(picture, "BELT", (150, 80), cv2.FONT_HERSHEY_DUPLEX, 2.2, 30, 7)
    for i in range(14):
        cv2.line(picture, (170 + 14 * i, 105), (170 + 14 * i, 145), 40, 2 + (i * 5) % 7)
    cv2.rectangle(picture, (330, 0), (352, 160), 120, -1)
    return picture


@functools.cache
def belt_sheet(seed: int = 5) -> np.ndarray:
    """(500, 2600) uint8 belt texture at 1 mm per pixel, columns along y."""
    rng = np.random.default_rng(seed)
    sheet = 60 + cv2.GaussianBlur(rng.normal(0, 60, (500, 2600)), (0, 0), 3)
    return sheet.clip(0, 255).astype(np.uint8)


@dataclass
class Scene:
    """Renders RGB and depth of a box at (x, y, yaw) on the moving belt."""

    K: np.ndarray
    T_world_camera: np.ndarray
    shape_px: tuple[int, int] = (480, 640)
    noise: float = 3.0
    depth_noise_m: float = 0.002
    light: float = 1.0
    picture_seed: int = 3

    def __post_init__(self) -> None:
        self.picture = box_picture(self.picture_seed)
        self.sheet = belt_sheet()
        self.rng = np.random.default_rng(11)
        rows, columns = self.shape_px
        u, v = np.meshgrid(np.arange(columns), np.arange(rows))
        rays = np.stack([u, v, np.ones_like(u)], -1) @ np.linalg.inv(self.K).T
        self.rays_z = (rays @ self.T_world_camera[:3, :3].T)[..., 2]
        self.ground = np.minimum(-self.T_world_camera[2, 3] / np.minimum(self.rays_z, -1e-3), 10.0)

    def plane(self, z_m: float, M: np.ndarray) -> np.ndarray:
        """(3, 3) homography picture px -> image px; M (2, 3) maps picture px to world xy."""
        world = np.vstack([M, [0, 0, z_m], [0, 0, 1]])
        return self.K @ np.linalg.inv(self.T_world_camera)[:3] @ world

    def render(self, x, y, yaw, occluder=None, with_box=True):
        """RGB (h, w, 3) uint8 and depth (h, w) float32.

        occluder: (x_low, x_high, y_low, y_high, z) rectangle in the world, or None.
        """
        size = self.shape_px[::-1]
        s = SHEET_M_PER_PX
        H = self.plane(0.0, np.array([[0, s, BELT_X0_M], [s, 0, BELT_Y0_M]]))
        grey = cv2.warpPerspective(self.sheet, H, size, flags=cv2.INTER_AREA).astype(float)
        depth = self.ground.copy()
        if with_box:
            h, w = self.picture.shape
            px = SIZE_M[0] / w
            c, sn = math.cos(yaw) * px, math.sin(yaw) * px
            # picture u along object +x, v along object -y
            R = np.array([[c, sn], [sn, -c]])
            t = np.array([x, y]) - R @ [(w - 1) / 2, (h - 1) / 2]
            self.paint_sides(grey, x, y, yaw)
            self.paint(grey, depth, self.picture, np.column_stack([R, t]), TOP_Z_M)
        if occluder is not None:
            x0, x1, y0, y1, z = occluder
            M = np.array([[0, (x1 - x0) / 50, x0], [(y1 - y0) / 50, 0, y0]])
            self.paint(grey, depth, np.full((50, 50), 130, np.uint8), M, z)
        grey = grey * self.light + self.rng.normal(0, self.noise, grey.shape)
        grey = grey.clip(0, 255).astype(np.uint8)
        depth = depth + self.rng.normal(0, self.depth_noise_m, depth.shape)
        return np.repeat(grey[..., None], 3, axis=2), depth.astype(np.float32)

    def paint_sides(self, grey, x, y, yaw):
        """The side faces, plain: the hull of the bottom and top rectangles."""
        a, b = SIZE_M[0] / 2, SIZE_M[1] / 2
        R = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
        xy = np.array([[a, b], [-a, b], [-a, -b], [a, -b]]) @ R.T + [x, y]
        corners = [np.append(p, z) for p in xy for z in (0.0, TOP_Z_M)]
        T = np.linalg.inv(self.T_world_camera)
        q = np.array(corners) @ T[:3, :3].T + T[:3, 3]
        q = q @ self.K.T
        hull = cv2.convexHull((q[:, :2] / q[:, 2:]).astype(np.float32))
        mask = np.zeros(grey.shape, np.uint8)
        cv2.fillConvexPoly(mask, (hull * 16).round().astype(np.int32), 1, shift=4)
        grey[mask > 0] = 105

    def paint(self, grey, depth, picture, M, z_m):
        size = self.shape_px[::-1]
        H = self.plane(z_m, M)
        layer = cv2.warpPerspective(picture, H, size, flags=cv2.INTER_AREA).astype(float)
        alpha = cv2.warpPerspective(np.full(picture.shape, 255, np.uint8), H, size) / 255.0
        grey[:] = alpha * layer + (1 - alpha) * grey
        on = alpha > 0.5
        depth[on] = ((z_m - self.T_world_camera[2, 3]) / self.rays_z)[on]


def angle_error(a: float, b: float) -> float:
    return (a - b + math.pi) % (2 * math.pi) - math.pi
