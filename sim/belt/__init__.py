"""The cell: a conveyor or a turntable, an object on it, and the referee of an attempt."""

from sim import require_offscreen_gl

require_offscreen_gl()
