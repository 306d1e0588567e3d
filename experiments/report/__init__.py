"""What results look like: tables, statistics, the style of figures, films."""
