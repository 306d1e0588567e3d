"""What the trials of a sweep say: tables, figures, comparisons of trackers."""
