"""Attitude of apples: the tables of [Zhou2011], and the estimators on rendered images."""
