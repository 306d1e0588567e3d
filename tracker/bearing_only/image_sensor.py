"""The image sensor: measures landmarks and target, as pixels with ids, in an image."""

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from tracker.bearing_only.camshift import CamShift, CamShiftConfig, ColourModel, Sighting
from tracker.bearing_only.corners import CornerConfig, CornerTracker, Rectangle
from tracker.bearing_only.measurements import FeatureObservation
from tracker.bearing_only.rigidity import RigidityCheck, RigidityConfig
from tracker.checks import require_count


@dataclass(frozen=True)
class ImageSensorConfig:
    """Settings of all that measures in the images."""

    corners: CornerConfig = field(default_factory=CornerConfig)
    rigidity: RigidityConfig = field(default_factory=RigidityConfig)
    target: CamShiftConfig = field(default_factory=CamShiftConfig)
    rim_px: int = 12
    """No landmark is sought so near to the target's window: its outline moves with it."""

    def __post_init__(self) -> None:
        require_count(self, "rim_px", least=0)


@dataclass(frozen=True, eq=False)
class ImageMeasurement:
    """What was measured in one image."""

    features: FeatureObservation
    """Landmarks that stood the test of the others."""
    sighting: Sighting

    @property
    def target_px(self) -> NDArray[np.float64] | None:
        """(2,) of the target; None where it is not seen whole, for then its centroid is off."""
        return self.sighting.centre_px if self.sighting.is_whole else None


class ImageSensor:
    """Measures in the images of one flight, in their order.

    Args:
        target_image: (h, w, 3) uint8 RGB of the target alone, from which its colour is learnt.
        config: The settings.
    """

    def __init__(
        self, target_image: NDArray[np.uint8], config: ImageSensorConfig | None = None
    ) -> None:
        self.config = config or ImageSensorConfig()
        self._camshift = CamShift(ColourModel(target_image, self.config.target))
        self._corners = CornerTracker(self.config.corners)
        self._rigidity = RigidityCheck(self.config.rigidity)

    def look(self, image: NDArray[np.uint8]) -> ImageMeasurement:
        """Landmarks and target in (h, w, 3) uint8 RGB, the next image."""
        sighting = self._camshift.update(image)
        grey = np.asarray(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), np.uint8)
        corners = self._corners.update(grey, self._around(sighting.window))
        is_odd, is_proven = self._rigidity.update(corners)
        self._corners.drop(corners.ids[is_odd])
        features = FeatureObservation(corners.ids[is_proven], corners.pixels[is_proven])
        return ImageMeasurement(features, sighting)

    def _around(self, window: Rectangle | None) -> Rectangle | None:
        if window is None:
            return None
        rim, (left, top, width, height) = self.config.rim_px, window
        return left - rim, top - rim, width + 2 * rim, height + 2 * rim
