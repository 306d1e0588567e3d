"""The filters as trackers of boxes in video, and what makes them last there."""
