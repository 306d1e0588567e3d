"""The camera: rendering, exposure, noise, delay, and the conditions under which it looks."""
