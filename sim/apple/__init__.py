"""An apple on its branch, leaves around it, and the UR5 that looks at it with a camera in hand."""

from sim import require_offscreen_gl

require_offscreen_gl()
