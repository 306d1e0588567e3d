"""Flights after a target that is seen by bearings alone: points, or a rendered hall."""
