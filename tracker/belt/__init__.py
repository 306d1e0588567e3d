"""From camera images of the belt to the target's pose and where it will be."""
