"""Flights after a target that is seen by bearings alone: points, or a rendered hall."""

from sim import require_offscreen_gl

require_offscreen_gl()
