"""Grasping from the belt: one attempt in the closed loop, sweeps of many, and their tables."""
