"""The OTB protocol: box trackers on video sequences, by OPE, TRE and SRE."""
