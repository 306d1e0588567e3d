"""Attitude of a fruit from the images of an eye-in-hand camera, by [Zhou2011] and beyond."""
