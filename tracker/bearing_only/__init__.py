"""One camera finds itself, its map and a moving target by bearings alone.  Source: [Wu2022]."""
