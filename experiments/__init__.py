"""Experiments: trials of the closed loop, sweeps of them, and what their rows say."""
