"""The method: particle filters on the affine group, and the parts they are made of."""
