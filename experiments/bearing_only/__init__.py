"""Bearing-only tracking: the studies of [Wu2022] section 6, and what beats its methods."""
