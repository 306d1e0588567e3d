"""Where the target will be when the delays are over.

All predictors take usable poses as they come and extrapolate to any time; yaw is unwrapped across
updates, and the target turns about the vertical only. Source: [IGPF2021] Eqs (27)-(30).
"""

import math
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tracker.belt.backproject import TargetPose
from tracker.checks import require_count, require_known, require_positive

_FULL_TURN = 2.0 * math.pi
_MIN_STEP_S = 1e-6


@dataclass(frozen=True, eq=False)
class TargetPrediction:
    """The target's top face at one time."""

    position_m: np.ndarray
    """(3,) centre of the top face in the world."""
    yaw_rad: float
    """Angle of the long axis about world z, unwrapped."""
    velocity_mps: np.ndarray
    """(3,) in the world."""
    yaw_rate_radps: float
    """About world z."""
    time_s: float
    """Time the prediction is for."""
    age_s: float
    """Time since the exposure of the last pose used."""

    def __post_init__(self) -> None:
        for name in ("position_m", "velocity_mps"):
            getattr(self, name).setflags(write=False)


@dataclass(frozen=True)
class PredictorConfig:
    """One way to extrapolate; a row of PREDICTORS."""

    description: str
    """One line for listings."""
    make: "Callable[[PredictorConfig], Predictor]"
    """Builds the predictor from its own configuration."""
    history_count: int = 9
    """Poses that count (k of Eq (27) plus one); the Kalman filter ignores it."""
    has_acceleration: bool = False
    """Add the weighted acceleration of Eq (28)."""
    acceleration_psd: tuple[float, float, float, float] = (0.004, 0.004, 0.0001, 0.02)
    """Spectral density of white acceleration of x, y, z [m^2/s^3] and yaw [rad^2/s^3]."""
    yaw_period_rad: float = _FULL_TURN
    """Turn after which the target looks the same: pi for an object with a half-turn symmetry."""
    max_gap_s: float = 1.0
    """Time without a pose after which the history no longer counts."""

    def __post_init__(self) -> None:
        require_count(self, "history_count", least=2)
        psd = np.asarray(self.acceleration_psd, float)
        if psd.shape != (4,) or not (np.isfinite(psd).all() and (psd > 0).all()):
            raise ValueError(
                f"acceleration_psd must be four positive numbers, got {self.acceleration_psd!r}"
            )
        require_positive(self, "yaw_period_rad", "max_gap_s")


class Predictor(ABC):
    """Extrapolates a sequence of poses; subclasses say how."""

    def __init__(self, config: PredictorConfig) -> None:
        self._config = config
        self._last: np.ndarray | None = None
        self._last_time_s = -math.inf

    def update(self, pose: TargetPose) -> None:
        """Takes in a pose; one that is not finite, or not newer than the last, is ignored."""
        z = np.array([*pose.position_m, pose.yaw_rad], float)
        if not (np.isfinite(z).all() and math.isfinite(pose.time_s)):
            return
        if pose.time_s <= self._last_time_s + _MIN_STEP_S:
            return
        if self._last is not None:
            period = self._config.yaw_period_rad
            z[3] -= period * round((z[3] - self._last[3]) / period)
        self._take(z, pose, pose.time_s - self._last_time_s > self._config.max_gap_s)
        self._last, self._last_time_s = z, pose.time_s

    @abstractmethod
    def predict(self, time_s: float) -> TargetPrediction | None:
        """The target at `time_s`; None before the first pose."""

    @abstractmethod
    def _take(self, z: np.ndarray, pose: TargetPose, is_new: bool) -> None:
        """Takes in x, y, z and unwrapped yaw (4,) of a pose; `is_new` where no history counts."""


class HistoryPredictor(Predictor):
    """Polynomial extrapolation of the last poses; subclasses fit the motion."""

    def __init__(self, config: PredictorConfig) -> None:
        super().__init__(config)
        self._poses: deque[np.ndarray] = deque(maxlen=config.history_count)
        self._times: deque[float] = deque(maxlen=config.history_count)

    def _take(self, z: np.ndarray, pose: TargetPose, is_new: bool) -> None:
        if is_new:
            self._poses.clear()
            self._times.clear()
        self._poses.append(z)
        self._times.append(pose.time_s)

    def predict(self, time_s: float) -> TargetPrediction | None:
        """Extrapolates position, velocity and acceleration of the last pose time."""
        if not self._poses:
            return None
        p, v, a = self._fit(np.array(self._times) - self._times[-1], np.array(self._poses))
        age_s = time_s - self._times[-1]
        return _prediction(p + v * age_s + 0.5 * a * age_s**2, v + a * age_s, time_s, age_s)

    @abstractmethod
    def _fit(self, t: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(4,) position, velocity and acceleration at t = 0 from times (k,) and poses (k, 4)."""


class LatestPose(HistoryPredictor):
    """No prediction: the target is where it was last seen."""

    def _fit(self, t: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return z[-1], np.zeros(4), np.zeros(4)


class WeightedDifferences(HistoryPredictor):
    """Weighted means of finite differences, newest heaviest. [IGPF2021] Eqs (27)-(29).

    Weights grow linearly with recency; the paper asks only that they sum to one.
    """

    def _fit(self, t: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        if len(t) < 2:
            return z[-1], np.zeros(4), np.zeros(4)
        velocity = np.diff(z, axis=0) / np.diff(t)[:, None]
        v = _recency_weights(len(velocity)) @ velocity
        if not self._config.has_acceleration or len(t) < 3:
            return z[-1], v, np.zeros(4)
        acceleration = np.diff(velocity, axis=0) / np.diff(t)[1:, None]
        return z[-1], v, _recency_weights(len(acceleration)) @ acceleration


class LeastSquares(HistoryPredictor):
    """Constant velocity, least squares over the history."""

    def _fit(self, t: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        if len(t) < 2:
            return z[-1], np.zeros(4), np.zeros(4)
        t_mean, z_mean = t.mean(), z.mean(axis=0)
        v = (t - t_mean) @ (z - z_mean) / ((t - t_mean) ** 2).sum()
        return z_mean - v * t_mean, v, np.zeros(4)


class KalmanConstantVelocity(Predictor):
    """A constant-velocity Kalman filter for x, y, z and yaw, each driven by white acceleration.

    Uses the measured covariance of every pose, floored: a filter that has seen hundreds of
    images is surer of itself than systematic errors allow.
    """

    _floor = np.array([1.5e-3, 1.5e-3, 2e-3, 0.01]) ** 2
    _initial_velocity_variance = np.array([1.0, 1.0, 1e-4, 1.0])

    def __init__(self, config: PredictorConfig) -> None:
        super().__init__(config)
        self._psd = np.asarray(config.acceleration_psd, float)
        self._state = np.zeros((4, 2))
        self._P = np.zeros((4, 2, 2))

    def _take(self, z: np.ndarray, pose: TargetPose, is_new: bool) -> None:
        """Time update to the pose's exposure, then measurement update."""
        variance = np.diagonal(pose.covariance)
        variance = np.where(np.isfinite(variance) & (variance > 0), variance, 0.0) + self._floor
        if is_new:
            self._state = np.stack([z, np.zeros(4)], axis=1)
            self._P = np.zeros((4, 2, 2))
            self._P[:, 0, 0] = variance
            self._P[:, 1, 1] = self._initial_velocity_variance
        else:
            self._advance(pose.time_s - self._last_time_s)
            gain = self._P[:, :, 0] / (self._P[:, 0, 0] + variance)[:, None]
            self._state = self._state + gain * (z - self._state[:, 0])[:, None]
            self._P = self._P - gain[:, :, None] * self._P[:, None, 0, :]

    def predict(self, time_s: float) -> TargetPrediction | None:
        """Extrapolates at constant velocity."""
        if self._last is None:
            return None
        age_s = time_s - self._last_time_s
        position, velocity = self._moved(age_s).T
        return _prediction(position, velocity, time_s, age_s)

    def _moved(self, step_s: float) -> np.ndarray:
        """(4, 2) values and rates of x, y, z and yaw, `step_s` later."""
        return self._state + step_s * np.outer(self._state[:, 1], [1.0, 0.0])

    def _advance(self, step_s: float) -> None:
        F = np.array([[1.0, step_s], [0.0, 1.0]])
        unit = np.array([[step_s**3 / 3, step_s**2 / 2], [step_s**2 / 2, step_s]])
        self._state = self._moved(step_s)
        self._P = F @ self._P @ F.T + self._psd[:, None, None] * unit


class KalmanCoordinatedTurn(KalmanConstantVelocity):
    """The velocity turns with the target, as on a turntable: speed and yaw rate are constant.

    The uncertainty of x and y is that of the straight filter; as the two are alike, turning one
    into the other changes nothing.
    """

    def _moved(self, step_s: float) -> np.ndarray:
        moved = super()._moved(step_s)
        turn = self._state[3, 1] * step_s
        c, s = math.cos(turn), math.sin(turn)
        along, aside = np.sinc(turn / math.pi), 0.5 * turn * np.sinc(0.5 * turn / math.pi) ** 2
        velocity = self._state[:2, 1]
        moved[:2, 0] = self._state[:2, 0] + step_s * (
            np.array([[along, -aside], [aside, along]]) @ velocity
        )
        moved[:2, 1] = np.array([[c, -s], [s, c]]) @ velocity
        return moved


PREDICTORS: dict[str, PredictorConfig] = {
    "kalman": PredictorConfig("constant-velocity Kalman filter", KalmanConstantVelocity),
    "turning": PredictorConfig(
        "the same, but the velocity turns with the target: for a turntable", KalmanCoordinatedTurn
    ),
    "least-squares": PredictorConfig("constant velocity by least squares", LeastSquares),
    "weighted": PredictorConfig(
        "weighted velocity and acceleration of the last poses, as in the paper",
        WeightedDifferences,
        has_acceleration=True,
    ),
    "weighted-velocity": PredictorConfig(
        "the paper's weighted velocity without the acceleration", WeightedDifferences
    ),
    "latest": PredictorConfig("no prediction: the last pose as it was", LatestPose),
}


def make_predictor(name: str) -> Predictor:
    """A new predictor of the named kind; ValueError that lists the valid names."""
    require_known("predictor", name, PREDICTORS)
    config = PREDICTORS[name]
    return config.make(config)


def _recency_weights(count: int) -> np.ndarray:
    weights = np.arange(1.0, count + 1.0)
    return weights / weights.sum()


def _prediction(
    z: np.ndarray, velocity: np.ndarray, time_s: float, age_s: float
) -> TargetPrediction:
    return TargetPrediction(
        position_m=z[:3].copy(),
        yaw_rad=float(z[3]),
        velocity_mps=velocity[:3].copy(),
        yaw_rate_radps=float(velocity[3]),
        time_s=time_s,
        age_s=age_s,
    )
