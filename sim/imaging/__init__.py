"""The camera: rendering, exposure, noise, delay, and the conditions under which it looks."""

from sim import require_offscreen_gl

require_offscreen_gl()
