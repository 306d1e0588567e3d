"""Short films of a textured target in MuJoCo, with the exact truth of every frame.

`clip` says what is to be seen and how things move, `pictures` and `surfaces` what they look like;
`stage` is the MuJoCo model that shows an instant, and `film` exposes the images and reads the
target out of it.
"""

from sim import require_offscreen_gl

require_offscreen_gl()
