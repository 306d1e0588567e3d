"""Trackers to compare with: OpenCV's, template matching, ECC, and those of users."""
