"""Hypothesis without deadlines (shared machines stall) and the same examples every run."""

from hypothesis import settings

settings.register_profile("laws", deadline=None, derandomize=True, max_examples=60)
settings.load_profile("laws")
