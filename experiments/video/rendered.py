"""One sequence of the rendered benchmark as a job, and the row that it leaves."""

from dataclasses import dataclass

from experiments.study.rows import JobOutcome


@dataclass(frozen=True)
class RenderJob:
    """One sequence of the benchmark; the seed draws motion, pictures and noise."""

    name: str
    seed: int

    def __post_init__(self) -> None:
        if self.seed < 0:
            raise ValueError(f"seed must be 0 or greater, got {self.seed}")

    def __str__(self) -> str:
        return f"{self.name}, seed {self.seed}"


@dataclass(frozen=True)
class RenderRow:
    """What a rendered sequence is, and where it comes from."""

    name: str
    attributes: str
    """Challenges, separated by blanks."""
    frames: int
    seed: int
    description: str
    outcome: JobOutcome
    commit: str
    mujoco_version: str
    detail: str = ""
