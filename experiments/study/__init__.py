"""One mechanism for every study: run what a folder lacks, keep it, survive a kill, report."""
